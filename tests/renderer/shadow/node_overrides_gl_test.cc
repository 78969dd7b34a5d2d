// Node overrides, as the camera and as the light see them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/shadow/shadow_method.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

constexpr int kSize = 64;
constexpr uint32_t kFloor = 0, kPlate = 1;

// Looked at from straight above: a floor, and above its left half a plate whose shadow falls on the right half too.
class NodeOverrideTest : public testing::TestWithParam<TestMethod> {
 protected:
  NodeOverrideTest() : scene_(MakeFlatScene({MakePlate({0, 0, 0}, 4, 4), MakePlate({-0.5, 1, 0}, 1, 4)})) {
    request_.camera = LookDown(1.5, 4);
    request_.width = request_.height = kSize;
    request_.lights = {LightAbove(3, 0.25, {-2, 0})};
    request_.method = GetParam().options;
  }

  NodeOverride& Change(uint32_t node) {
    request_.node_overrides.emplace_back().node = node;
    return request_.node_overrides.back();
  }
  Image Visibility() const { return RenderVisibility(scene_, request_); }

  FlatScene scene_;
  RenderRequest request_;
};
INSTANTIATE_TEST_SUITE_P(Methods, NodeOverrideTest, testing::ValuesIn(TestMethods()), TestMethodName);

bool Equal(const Image& a, const Image& b) {
  return a.size() == b.size() && a.size() > 0 && std::equal(a.data(), a.data() + a.size(), b.data());
}

// The plate, x in [-1, 0], throws its shadow on x in [-.5, 1]: these two pixels' floors are well inside.
constexpr int kInShadow = kSize / 2 + kSize / 8;
constexpr int kOnPlate = kSize / 2 - kSize / 16;

TEST_P(NodeOverrideTest, InvisibleIsNotDrawnAndStillCasts) {
  const Image before = Visibility();
  ASSERT_EQ(before.at(kInShadow, kSize / 2, 0), 0);
  ASSERT_EQ(before.at(kOnPlate, kSize / 2, 0), 1);
  Change(kPlate).is_visible = false;
  const Image after = Visibility();
  EXPECT_EQ(after.at(kInShadow, kSize / 2, 0), 0);
  EXPECT_EQ(after.at(kOnPlate, kSize / 2, 0), 0) << "the floor under the plate is seen, in its shadow";
}

TEST_P(NodeOverrideTest, WhatDoesNotCastIsDrawnAndHidesNoLight) {
  Change(kPlate).casts = false;
  const Image v = Visibility();
  ASSERT_GT(v.size(), 0u);
  EXPECT_EQ(*std::min_element(v.data(), v.data() + v.size()), 1);
  RenderReport report;
  RenderVisibility(scene_, request_, &report);
  EXPECT_EQ(report.share_lit, 1);
}

TEST_P(NodeOverrideTest, NeitherDrawnNorCastingIsAsIfItWereNotThere) {
  NodeOverride& change = Change(kPlate);
  change.is_visible = change.casts = false;
  const Image changed = Visibility();
  request_.node_overrides.clear();
  scene_ = MakeFlatScene({MakePlate({0, 0, 0}, 4, 4)});
  EXPECT_TRUE(Equal(changed, Visibility()));
}

TEST_P(NodeOverrideTest, WhatDoesNotReceiveIsFullyLitBelowTheHorizonAndBehindTheLightToo) {
  Change(kFloor).receives = false;
  Image v = Visibility();
  ASSERT_GT(v.size(), 0u);
  EXPECT_EQ(*std::min_element(v.data(), v.data() + v.size()), 1);
  // From below, lit from above: all of the light is under the floor's horizon.
  request_.camera = LookFrom({1.2, -3, 0.3}, {1, 0, 0});
  EXPECT_EQ(Visibility().at(kSize / 2, kSize / 2, 0), 1);
  request_.node_overrides.clear();
  EXPECT_EQ(Visibility().at(kSize / 2, kSize / 2, 0), 0);
  // The light under the floor, shining down; the plate above receives, so that the light is not left out.
  request_.camera = LookDown(1.5, 4);
  request_.lights[0].center_ws.y = -1;
  EXPECT_EQ(Visibility().at(kInShadow, kSize / 2, 0), 0);
  Change(kFloor).receives = false;
  EXPECT_EQ(Visibility().at(kInShadow, kSize / 2, 0), 1);
  EXPECT_EQ(Visibility().at(kOnPlate, kSize / 2, 0), 0);
}

TEST_P(NodeOverrideTest, WhereNothingChangesNoBitDoes) {
  // The plate does not receive: its own pixels are 1, the floor's are what they were.
  const Image before = Visibility();
  Change(kPlate).receives = false;
  const Image after = Visibility();
  ASSERT_EQ(before.size(), after.size());
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double wx = ((x + 0.5) / kSize - 0.5) * 4;
      const bool is_on_plate = wx > -1 && wx < 0;
      ASSERT_EQ(after.at(x, y, 0), is_on_plate ? 1 : before.at(x, y, 0)) << x << "," << y;
    }
  }
}

TEST_P(NodeOverrideTest, ATransformMovesObjectAndShadow) {
  Change(kPlate).local = glm::translate(glm::dmat4(1), {0.25, 0, 0.5});
  const Image moved = Visibility();
  request_.node_overrides.clear();
  scene_ = MakeFlatScene({MakePlate({0, 0, 0}, 4, 4), MakePlate({-0.25, 1, 0.5}, 1, 4)});
  const Image there = Visibility();
  if (!FindMethod(request_.method).method->KeepsMovedApart()) {
    EXPECT_TRUE(Equal(moved, there));
    return;
  }
  // The plate's shadow is another method's then: the same but for both methods' errors in the penumbra.
  ASSERT_EQ(moved.size(), there.size());
  double off = 0;
  for (size_t i = 0; i < moved.size(); ++i) off += std::abs(moved.data()[i] - there.data()[i]) / double(moved.size());
  EXPECT_LE(off, 0.005);
}

}  // namespace
}  // namespace halfshade
