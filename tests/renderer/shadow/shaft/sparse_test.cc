#include "renderer/shadow/shaft/sparse.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

constexpr int kWidth = 22, kHeight = 18;   // neither is a whole number of blocks
constexpr glm::vec4 kGround(0, 1, 0, -2);  // two metres below the eye

// A ground that is looked down upon, with hidden fractions by pixel at the evaluated ones.
struct Picture {
  CpuReceivers receivers;
  std::vector<float> hidden, errors;
  explicit Picture(const std::function<float(int, int)>& field) {
    receivers.camera = LookDown(2, 4);
    receivers.width = kWidth;
    receivers.height = kHeight;
    receivers.planes.assign(kWidth * kHeight, kGround);
    hidden.assign(kWidth * kHeight, 0);
    errors.assign(kWidth * kHeight, -1);
    for (int row = 0; row * SparseGrid::kBlock < kHeight; ++row) {
      for (int column = 0; column * SparseGrid::kBlock < kWidth; ++column) {
        const int x = SparseGrid::PixelOf(column, kWidth), y = SparseGrid::PixelOf(row, kHeight);
        hidden[y * kWidth + x] = field(x, y);
        errors[y * kWidth + x] = 0.001f;
      }
    }
  }
  bool Interpolate(int column, int row, float most_bend = 0.01f) {
    return SparseGrid(receivers, hidden, errors).Interpolate(column, row, most_bend, &hidden, &errors);
  }
};

float Slope(int x, int y) { return 0.1f + 0.02f * float(x) + 0.01f * float(y); }

TEST(SparseGridTest, WhatIsLinearIsToldExactly) {
  Picture picture(Slope);
  ASSERT_TRUE(picture.Interpolate(2, 2));
  for (int y = 8; y < 12; ++y) {
    for (int x = 8; x < 12; ++x) {
      EXPECT_NEAR(picture.hidden[y * kWidth + x], Slope(x, y), 1e-6) << x << " " << y;
      EXPECT_NEAR(picture.errors[y * kWidth + x], 0.00075, 1e-6);
    }
  }
  EXPECT_LT(picture.errors[7 * kWidth + 7], 0) << "a block is told alone";
}

TEST(SparseGridTest, ABendUpToTheMostIsToldAndAnotherIsNot) {
  const auto bent = [](int x, int) { return 0.1f + 0.01f * std::abs(float(x - 9)); };  // 4 pixels, both ways
  EXPECT_TRUE(Picture(bent).Interpolate(2, 2, 0.081f));
  EXPECT_FALSE(Picture(bent).Interpolate(2, 2, 0.079f));
}

TEST(SparseGridTest, ABlockOfTwoSurfacesIsNotTold) {
  Picture step(Slope);
  step.receivers.planes[9 * kWidth + 10] = {0, 1, 0, -1};  // a pixel of a table
  EXPECT_FALSE(step.Interpolate(2, 2));
  Picture wall(Slope);
  wall.receivers.planes[9 * kWidth + 10] = {1, 0, 0, -2};
  EXPECT_FALSE(wall.Interpolate(2, 2));
  Picture hole(Slope);
  hole.receivers.planes[9 * kWidth + 10] = glm::vec4(0);  // nothing is drawn there
  EXPECT_FALSE(hole.Interpolate(2, 2));
}

TEST(SparseGridTest, ABlockBesideOneThatIsNotEvaluatedIsNotTold) {
  Picture picture(Slope);
  picture.errors[13 * kWidth + 13] = -1;
  EXPECT_FALSE(picture.Interpolate(2, 2));
  EXPECT_TRUE(picture.Interpolate(1, 1));
}

TEST(SparseGridTest, EveryPixelOfAFlatPictureIsToldToTheCorners) {
  Picture picture([](int, int) { return 0.25f; });
  const SparseGrid grid(picture.receivers, picture.hidden, picture.errors);
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      EXPECT_TRUE(grid.Interpolate(column, row, 0, &picture.hidden, &picture.errors));
    }
  }
  for (const float hidden : picture.hidden) EXPECT_EQ(hidden, 0.25f);
  for (const float error : picture.errors) EXPECT_GE(error, 0);
}

}  // namespace
}  // namespace halfshade
