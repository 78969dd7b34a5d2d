#include "renderer/light/picture_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace halfshade {
namespace {

constexpr int kSize = 64;
constexpr float kTold = 0.05f;

class PictureErrorTest : public testing::Test {
 protected:
  PictureErrorTest() {
    receivers_.width = receivers_.height = kSize;
    receivers_.planes.assign(kSize * kSize, {0, 1, 0, -2});
  }

  // Penumbra v(x, y), with errors evenly spread on both sides, of mean size `noise`.
  Image Noisy(double noise, const std::function<double(int, int)>& v) {
    std::mt19937 random(3);
    Image image(kSize, kSize, 2);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const double error = noise * (4.0 * double(random()) / 4294967296.0 - 2);
        image.at(x, y, 0) = float(v(x, y) + error);
        image.at(x, y, 1) = 1;
      }
    }
    return image;
  }
  // Over the picture but for its rim, whose pixels have neighbours on one side alone.
  double Mean(const Image& image, const CpuReceivers* receivers) {
    std::vector<float> errors(kSize * kSize, kTold);
    for (int i = 0; i < kSize; ++i) {
      for (const int k : {0, kSize - 1}) errors[i * kSize + k] = errors[k * kSize + i] = 0;
    }
    const PictureError error = ExpectPictureError(image, errors, receivers);
    EXPECT_EQ(error.pixels, uint64_t(kSize) * kSize);
    return error.sum / (double(kSize - 2) * (kSize - 2));
  }

  CpuReceivers receivers_;
};

double Slope(int x, int y) { return 0.2 + 0.006 * x + 0.003 * y; }

TEST_F(PictureErrorTest, UnderASlopeTheNoiseOfNeighboursIsTheError) {
  for (const double noise : {0.001, 0.004, 0.016}) {
    EXPECT_NEAR(Mean(Noisy(noise, Slope), &receivers_), noise, 0.25 * noise);
  }
}

TEST_F(PictureErrorTest, WhatSamplesSayIsNeverRaised) {
  EXPECT_NEAR(Mean(Noisy(0.08, [](int, int) { return 0.5; }), &receivers_), kTold, 1e-6);
}

TEST_F(PictureErrorTest, CurvedAcrossAnEdgeItIsReadAlongTheEdge) {
  const auto curved = [](double along) { return 0.5 + 0.4 * std::sin(along / 3); };
  EXPECT_NEAR(Mean(Noisy(0.002, [&](int x, int) { return curved(x); }), &receivers_), 0.002, 0.0006);
  EXPECT_NEAR(Mean(Noisy(0.002, [&](int x, int y) { return curved(x - y); }), &receivers_), 0.002, 0.0006);
  // With no straight direction it errs upwards.
  EXPECT_GT(Mean(Noisy(0.002, [&](int x, int y) { return curved(x * y / 8.0); }), &receivers_), 0.003);
}

TEST_F(PictureErrorTest, WhereNeighboursSayNothingSamplesAreBelieved) {
  const Image image = Noisy(0.001, Slope);
  EXPECT_NEAR(Mean(image, nullptr), kTold, 1e-6) << "errors are not independent";
  CpuReceivers checkered = receivers_, steps = receivers_;
  for (size_t i = 0; i < size_t(kSize) * kSize; ++i) {
    const size_t x = i % kSize, y = i / kSize;
    // No two beside or across from each other face alike, or stand in one plane.
    const glm::vec4 sides[] = {{1, 0, 0, -2}, {0, 1, 0, -2}, {0, 0, 1, -2}, {-1, 0, 0, -2}};
    checkered.planes[i] = sides[x % 2 + 2 * (y % 2)];
    steps.planes[i].w = -2 * std::pow(1.1f, float(x % 2 + 2 * (y % 2)));
  }
  EXPECT_NEAR(Mean(image, &checkered), kTold, 1e-6);
  EXPECT_NEAR(Mean(image, &steps), kTold, 1e-6);
}

TEST_F(PictureErrorTest, LightCountsForNothingAndAFewPixelsKeepTheirWord) {
  Image image(kSize, kSize, 2);
  for (size_t i = 0; i < size_t(kSize) * kSize; ++i) image.data()[2 * i] = image.data()[2 * i + 1] = 1;
  const std::vector<float> errors(kSize * kSize, kTold);
  EXPECT_EQ(ExpectPictureError(image, errors, &receivers_).pixels, 0u);
  for (int x = 0; x < 8; ++x) image.at(x, 5, 0) = 0.5f;
  const PictureError few = ExpectPictureError(image, errors, &receivers_);
  EXPECT_EQ(few.pixels, 8u);
  EXPECT_NEAR(few.sum, 8 * kTold, 1e-6);
}

}  // namespace
}  // namespace halfshade
