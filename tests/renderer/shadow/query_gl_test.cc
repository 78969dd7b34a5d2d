// Points through every method.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/support/closed_forms.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

class QueryTest : public testing::TestWithParam<TestMethod> {
 protected:
  std::vector<float> Query(const FlatScene& scene, const QueryPoints& points, const std::vector<AreaLight>& lights) {
    RenderRequest request;
    request.lights = lights;
    request.method = GetParam().options;
    auto result = TestRenderer().QueryVisibility("test", scene, request, points, [] { return absl::OkStatus(); });
    TestRenderer().ForgetScene("test");
    EXPECT_OK(result);
    if (!result.ok()) return std::vector<float>(points.points_ws.size() * lights.size(), -1);
    EXPECT_EQ(result->report.method, GetParam().name);
    EXPECT_EQ(result->visibility.size(), points.points_ws.size() * lights.size());
    return result->visibility;
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, QueryTest, testing::ValuesIn(TestMethods()), TestMethodName);

constexpr int kSize = 64;
constexpr double kEdge = 3.2;

// What LookDown(_, kEdge) sees of the ground y = 0.
QueryPoints PixelCentres(glm::vec3 normal) {
  QueryPoints points;
  for (int i = 0; i < kSize * kSize; ++i) {
    const double x = ((i % kSize + 0.5) / kSize - 0.5) * kEdge, z = ((i / kSize + 0.5) / kSize - 0.5) * kEdge;
    points.points_ws.emplace_back(x, 0, z);
    if (normal != glm::vec3(0)) points.normals_ws.push_back(normal);
  }
  return points;
}

TEST_P(QueryTest, PixelCentresAskedAsPointsGiveThePicture) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request;
  request.camera = LookDown(0.5, kEdge);
  request.width = request.height = kSize;
  request.lights = {LightAbove(2, 0.4)};
  request.method = GetParam().options;
  // Pixels may share what points, which have no neighbours, find for themselves.
  if (auto* sssm = std::get_if<SssmOptions>(&request.method)) sssm->alpha = sssm->beta = 0;
  const Image picture = RenderVisibility(scene, request);
  ASSERT_GT(picture.size(), 0u);
  const std::vector<float> v = Query(scene, PixelCentres({0, 1, 0}), request.lights);
  double sum = 0;
  int different = 0;
  for (int i = 0; i < kSize * kSize; ++i) {
    const double difference = std::abs(v[i] - picture.data()[i]);
    different += difference > 1e-5;
    sum += difference;
  }
  std::printf("%s: %d points of %d differ, mean %.2g\n", GetParam().name.c_str(), different, kSize * kSize,
              sum / kSize / kSize);
  if (GetParam().shared_samples > 0) {
    // Two sets of so many stratified samples, each within .7 sqrt(v (1 - v)) k^-.75 (trace_light.h), v = 1/2.
    EXPECT_LE(sum / std::max(1, different), 2 * 0.7 * 0.5 * std::pow(GetParam().shared_samples, -0.75));
    return;
  }
  // Both are the same but for the rounding of positions, which moves a point over an edge where one runs through it.
  EXPECT_LE(different, 4);
  EXPECT_LE(sum / kSize / kSize, 1e-5);
}

TEST_P(QueryTest, ANormalBringsTheHorizonAndNoneLeavesItOut) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 1, 30}, 0.8, 0.8)});
  // The light's middle stands in the plane of these points.
  const glm::vec3 level(1, 0, 0);
  const AreaLight light = LightAbove(2, 0.4);
  const std::vector<float> cut = Query(scene, {{{0, 0.5f, 0}}, {level}}, {light});
  EXPECT_NEAR(cut[0], 0.5, 1e-6);  // nothing occludes: the share of the horizon alone
  EXPECT_EQ(Query(scene, {{{0, 0.5f, 0}}, {{0, -1, 0}}}, {light})[0], 0);
  EXPECT_EQ(Query(scene, {{{0, 0.5f, 0}}, {}}, {light})[0], 1);
}

TEST_P(QueryTest, PointsInTheAirBehindAPlateSeeNothingAndBesideItAll) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8)});
  const std::vector<float> v = Query(
      scene, {{{0, 0.9f, 0}, {0, 1.1f, 0}, {0, 0.5f, 0.1f}, {3, 0.5f, 0}, {0, 2.5f, 0}}, {}}, {LightAbove(2, 0.4)});
  EXPECT_EQ(v, std::vector<float>({0, 1, 0, 1, 0}));
}

TEST_P(QueryTest, EachLightHasItsColumnAndATwoSidedOneShinesBothWays) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 3, 0}, 0.8, 0.8)});
  AreaLight both = LightAbove(2, 0.4);
  both.is_two_sided = true;
  const std::vector<float> v =
      Query(scene, {{{0, 0.9f, 0}, {0, 2.5f, 0}, {0, 3.1f, 0}, {3, 2.5f, 0}}, {}}, {LightAbove(2, 0.4), both});
  EXPECT_EQ(v, std::vector<float>({0, 0, 0, 1, 0, 0, 0, 1}));
}

// More than a row of receivers, far from the world's origin.
TEST_P(QueryTest, ManyPointsFarAwayKeepTheirPlaces) {
  const glm::dvec3 far(4096, 0, -8192);
  const FlatScene scene = MakeFlatScene({MakePlate(far + glm::dvec3(0, 1, 0), 0.8, 0.8)});
  AreaLight light = LightAbove(2, 0.4);
  light.center_ws += far;
  QueryPoints points;
  for (int i = 0; i < 2500; ++i) points.points_ws.push_back(glm::vec3(far + glm::dvec3(i % 2 == 0 ? 0 : 3, 0.5, 0)));
  const std::vector<float> v = Query(scene, points, {light});
  for (int i = 0; i < 2500; ++i) ASSERT_EQ(v[i], i % 2) << i;
}

}  // namespace
}  // namespace halfshade
