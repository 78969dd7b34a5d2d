// What a request moves hides light on its own, over light data of the rest that stays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

constexpr uint32_t kFloor = 0, kPlate = 1, kBox = 2;

// A floor, a plate over it, and a box that is moved about under and beside the plate.
class MovedApartTest : public testing::Test {
 protected:
  MovedApartTest()
      : scene_(MakeFlatScene(
            {MakePlate({0, 0, 0}, 6, 6), MakePlate({0, 1.2, 0}, 1, 1), MakeBox({0, 0.2, 0}, {0.4, 0.4, 0.4})})) {
    request_.camera = LookFrom({2.5, 2.5, 2.5}, {0, 0.3, 0});
    request_.width = 160;
    request_.height = 120;
    request_.lights = {LightAbove(3, 0.5, {0.5, 0.3})};
    request_.outputs = {OutputKind::kVisibility};
    request_.method = PdsmOptions{};
  }
  ~MovedApartTest() override { TestRenderer().ForgetScene("moved"); }
  void MoveBox(const glm::dvec3& by) {
    request_.node_overrides = {{.node = kBox, .local = glm::translate(glm::dmat4(1), by)}};
  }
  RenderResult Render() {
    auto result = TestRenderer().Render("moved", scene_, request_, [] { return absl::OkStatus(); });
    EXPECT_OK(result);
    return *std::move(result);
  }
  static const PassReport* Pass(const RenderReport& report, const std::string& name) {
    const auto found = std::find_if(report.passes.begin(), report.passes.end(),
                                    [&](const PassReport& pass) { return pass.name == name; });
    return found == report.passes.end() ? nullptr : &*found;
  }
  struct Error {
    double mae = 0, worst = 0;
    int shadowed = 0;
  };
  // Of PDSM against rays in the scene as it is moved.
  Error AgainstRays() {
    const Image v = Render().images[0].image;
    request_.method = RayOptions{1024};
    const Image truth = Render().images[0].image;
    request_.method = PdsmOptions{};
    Error error;
    for (size_t i = 0; i < v.size(); ++i) {
      if (truth.data()[i] >= 1 - 1.0f / 512) continue;
      const double off = std::abs(v.data()[i] - truth.data()[i]);
      error.mae += off;
      error.worst = std::max(error.worst, off);
      ++error.shadowed;
    }
    error.mae /= error.shadowed;
    return error;
  }

  FlatScene scene_;
  RenderRequest request_;
};

TEST_F(MovedApartTest, MovingANodeDoesNotRebuildTheRest) {
  MoveBox({1, 0, 0});
  const RenderReport first = Render().report;
  EXPECT_EQ(Pass(first, "light[0]/light_data")->count, 64u);
  MoveBox({1, 0.1, 0.2});
  const RenderReport second = Render().report;
  EXPECT_TRUE(Pass(second, "light[0]/light_data")->is_skipped);
  EXPECT_EQ(Pass(second, "light[0]/light_data")->reason, "cached");
  ASSERT_NE(Pass(second, "light[0]/light_data/moved"), nullptr);
  EXPECT_FALSE(Pass(second, "light[0]/light_data/moved")->is_skipped);
  EXPECT_LT(Pass(second, "light[0]/light_data/moved")->count, 64u);
}

TEST_F(MovedApartTest, BesideTheStillShadowItIsAsGoodAsBothAre) {
  MoveBox({1.5, 0, -0.6});
  const Error error = AgainstRays();
  std::printf("apart: mae_shadowed %.4f, worst %.3f of %d\n", error.mae, error.worst, error.shadowed);
  EXPECT_GT(error.shadowed, 800);
  // Of PDSM k = 64 and of SSM as it chooses, at contact with the floor.
  EXPECT_LE(error.mae, 0.02);
}

// Both hide light: the truth is the union of what they hide, the product takes them to be independent.
TEST_F(MovedApartTest, WhereBothShadowsMeetTheProductStaysBetweenItsBounds) {
  for (const glm::dvec3 by : {glm::dvec3(-0.3, 0, -0.2), glm::dvec3(-0.7, 0.3, 0), glm::dvec3(0.3, 1.4, 0.2)}) {
    MoveBox(by);
    const Error error = AgainstRays();
    std::printf("box moved by %.1f %.1f %.1f: mae_shadowed %.4f, worst %.3f of %d\n", by.x, by.y, by.z, error.mae,
                error.worst, error.shadowed);
    // Two occluders that hide half of the light each hide at most all and at least half: the product is off by 1/4.
    EXPECT_LE(error.worst, 0.25 + 0.15);
    EXPECT_LE(error.mae, 0.03);
  }
}

TEST_F(MovedApartTest, WhatIsMovedReceivesFromTheRestAndFromItself) {
  MoveBox({-0.3, 0, -0.2});
  request_.outputs = {OutputKind::kVisibility, OutputKind::kObjectId};
  const RenderResult result = Render();
  int umbra = 0, lit = 0;
  for (size_t i = 0; i < result.images[0].image.size(); ++i) {
    if (result.images[1].image.data()[i] != kBox + 1) continue;
    umbra += result.images[0].image.data()[i] < 0.05f;
    lit += result.images[0].image.data()[i] > 0.95f;
  }
  EXPECT_GT(umbra, 100) << "the box stands in the plate's shadow";
  MoveBox({1.5, 0, -0.6});
  const RenderResult moved = Render();
  for (size_t i = 0; i < moved.images[0].image.size(); ++i) {
    lit += moved.images[1].image.data()[i] == kBox + 1 && moved.images[0].image.data()[i] > 0.95f;
  }
  EXPECT_GT(lit, 100);
}

TEST_F(MovedApartTest, WhatIsMovedAndDoesNotCastHasNoLayer) {
  MoveBox({1, 0, 0});
  request_.node_overrides[0].casts = false;
  const RenderReport report = Render().report;
  EXPECT_EQ(Pass(report, "light[0]/light_data/moved"), nullptr);
  request_.node_overrides[0].local = glm::translate(glm::dmat4(1), {2.0, 0.0, 0.0});
  EXPECT_TRUE(Pass(Render().report, "light[0]/light_data")->is_skipped);
}

TEST_F(MovedApartTest, WhereEverythingIsMovedOnlyItsLayerIsThere) {
  request_.node_overrides = {{.node = kFloor, .local = std::nullopt, .casts = false},
                             {.node = kPlate, .local = glm::dmat4(1)},
                             {.node = kBox, .local = glm::dmat4(1)}};
  const RenderReport report = Render().report;
  EXPECT_EQ(Pass(report, "light[0]/light_data"), nullptr);
  EXPECT_NE(Pass(report, "light[0]/light_data/moved"), nullptr);
}

TEST_F(MovedApartTest, PointsSeeBothLayersToo) {
  MoveBox({-0.3, 0, -0.2});
  QueryPoints points;
  for (int i = 0; i < 40; ++i) points.points_ws.emplace_back(-2 + 0.1f * float(i), 0.05f, -0.4f);
  points.normals_ws.assign(points.points_ws.size(), {0, 1, 0});
  const auto ask = [&] {
    auto result = TestRenderer().QueryVisibility("moved", scene_, request_, points, [] { return absl::OkStatus(); });
    EXPECT_OK(result);
    return result->visibility;
  };
  const std::vector<float> v = ask();
  request_.method = RayOptions{1024};
  const std::vector<float> truth = ask();
  double off = 0;
  for (size_t i = 0; i < v.size(); ++i) off += std::abs(v[i] - truth[i]) / double(v.size());
  EXPECT_LE(off, 0.03);
  EXPECT_LT(*std::min_element(truth.begin(), truth.end()), 0.1f);
  EXPECT_GT(*std::max_element(truth.begin(), truth.end()), 0.9f);
}

}  // namespace
}  // namespace halfshade
