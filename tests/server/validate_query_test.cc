// What a query of points may hold, on both sides of each bound.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>

#include "server/validate.h"
#include "tests/server/validate_request.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using Code = absl::StatusCode;
using Query = v1::QueryVisibilityRequest;

std::string Pack(const std::vector<float>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
}

Query GoodQuery() {
  Query query;
  *query.mutable_request() = Good();
  query.set_points(Pack({1, 2, 3, 4, 5, 6}));
  query.set_normals(Pack({0, 1, 0, 0, 0, -1}));
  return query;
}

struct Row {
  std::string name;
  std::function<void(Query&)> change;
  Code code;
  std::string message;
};

std::vector<Row> Rows() {
  const Code ok = Code::kOk, bad = Code::kInvalidArgument;
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  return {
      {"AsItIs", [](Query&) {}, ok, ""},
      {"NoNormals", [](Query& q) { q.clear_normals(); }, ok, ""},
      {"NoPoints", [](Query& q) { q.clear_points(); }, bad, "points: missing"},
      {"BytesOverAPoint", [](Query& q) { q.mutable_points()->push_back(0); }, bad,
       "points: 25 bytes; must be a multiple of 12"},
      {"BytesOverANormal", [](Query& q) { q.mutable_normals()->push_back(0); }, bad,
       "normals: 25 bytes; must be a multiple of 12"},
      {"NormalsOfAnotherCount",
       [](Query& q) {
         q.set_normals(Pack({0, 1, 0}));
       },
       bad, "normals: 1; must be none, or one for each of 2 points"},
      {"PointNan",
       [=](Query& q) {
         q.set_points(Pack({1, 2, 3, 4, nan, 6}));
       },
       bad, "points[1].y: nan; must be finite"},
      {"PointInf",
       [=](Query& q) {
         q.set_points(Pack({-inf, 2, 3, 4, 5, 6}));
       },
       bad, "points[0].x: -inf; must be finite"},
      {"PointFar",
       [](Query& q) {
         q.set_points(Pack({1, 2, 1e15f, 4, 5, 6}));
       },
       ok, ""},
      {"PointTooFar",
       [](Query& q) {
         q.set_points(Pack({1, 2, 1.1e15f, 4, 5, 6}));
       },
       bad, "points[0].z: "},
      {"NormalNearlyUnit",
       [](Query& q) {
         q.set_normals(Pack({0, 1.0009f, 0, 0, 0, -0.9991f}));
       },
       ok, ""},
      {"NormalLong",
       [](Query& q) {
         q.set_normals(Pack({0, 1.0011f, 0, 0, 0, -1}));
       },
       bad, "normals[0]: length 1.001"},
      {"NormalZero",
       [](Query& q) {
         q.set_normals(Pack({0, 1, 0, 0, 0, 0}));
       },
       bad, "normals[1]: length 0; must be a unit vector within 1e-3"},
      {"NormalNan",
       [=](Query& q) {
         q.set_normals(Pack({0, 1, 0, 0, nan, 0}));
       },
       bad, "normals[1].y: nan; must be finite"},
      {"LightsAreLookedAt", [](Query& q) { q.mutable_request()->mutable_lights(0)->clear_center(); }, bad,
       "lights[0].center: missing"},
      {"MethodIsLookedAt", [](Query& q) { q.mutable_request()->mutable_method()->mutable_ray()->set_rays(0); }, bad,
       "method.ray.rays: 0"},
      {"CameraSizeAndOutputsAreNot",
       [](Query& q) {
         LookAt(*q.mutable_request()).set_fovy_deg(500);
         q.mutable_request()->set_width(100000);
         q.mutable_request()->add_outputs()->set_kind(v1::OUTPUT_KIND_PENUMBRA_WIDTH);
       },
       ok, ""},
  };
}

class ValidateQueryTest : public testing::TestWithParam<Row> {};
INSTANTIATE_TEST_SUITE_P(Rows, ValidateQueryTest, testing::ValuesIn(Rows()),
                         [](const auto& row) { return row.param.name; });

TEST_P(ValidateQueryTest, SaysFieldValueAndBound) {
  Query query = GoodQuery();
  GetParam().change(query);
  const auto valid = ValidateQuery(query, Scene(), Limits());
  EXPECT_THAT(valid, StatusIs(GetParam().code, testing::StartsWith(GetParam().message)));
  EXPECT_EQ(CheckQueryFields(query, Limits()).code(), GetParam().code);
}

TEST(ValidateQueryTest, ThePointsComeAsTheyAre) {
  const auto valid = ValidateQuery(GoodQuery(), Scene(), Limits());
  ASSERT_OK(valid);
  EXPECT_EQ(valid->points.points_ws, std::vector<glm::vec3>({{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(valid->points.normals_ws, std::vector<glm::vec3>({{0, 1, 0}, {0, 0, -1}}));
}

// Rays measure the error of pictures: what tells none is not chosen for points, and a certificate is none of theirs.
TEST(ValidateQueryTest, AutoTakesWhatTellsItsError) {
  Query query = GoodQuery();
  v1::RenderRequest& request = *query.mutable_request();
  request.mutable_method()->mutable_auto_();
  request.mutable_budget()->set_max_error(0.03);
  request.set_expected_frames(1'000'000);
  for (const bool has_gpu : {false, true}) {
    const auto valid = ValidateQuery(query, Scene(), Limits(), {.has_gpu = has_gpu});
    ASSERT_OK(valid);
    EXPECT_TRUE(std::holds_alternative<ShaftOptions>(valid->request.method)) << valid->request.method_reason;
    EXPECT_FALSE(valid->request.certify);
  }
}

TEST(ValidateQueryTest, AReplyThatPassesTheBoundIsRefused) {
  Limits limits;
  Query query = GoodQuery();
  *query.mutable_request()->add_lights() = query.request().lights(0);
  limits.render_reply_bytes = 2 * 2 * 4;
  EXPECT_OK(CheckQueryFields(query, limits));
  --limits.render_reply_bytes;
  EXPECT_THAT(CheckQueryFields(query, limits),
              StatusIs(Code::kFailedPrecondition,
                       testing::HasSubstr("points: 2 for 2 lights are a reply of 16 bytes; at most 15")));
}

}  // namespace
}  // namespace halfshade
