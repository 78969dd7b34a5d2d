#include "renderer/image/surface_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace halfshade {
namespace {

constexpr int kSize = 16;

// A floor, a metre a pixel.
Surfaces Floor() {
  Surfaces surfaces;
  for (int i = 0; i < kSize * kSize; ++i) {
    surfaces.points.emplace_back(i % kSize, 0, i / kSize);
    surfaces.normals.emplace_back(0, 1, 0);
  }
  return surfaces;
}

Image Noise() {
  Image image(kSize, kSize, 1);
  std::mt19937 random(3);
  for (size_t i = 0; i < image.size(); ++i) image.data()[i] = float(random() & 1);
  return image;
}

double Deviation(const Image& image) {
  double sum = 0;
  for (size_t i = 0; i < image.size(); ++i) sum += (image.data()[i] - 0.5) * (image.data()[i] - 0.5);
  return std::sqrt(sum / double(image.size()));
}

TEST(SurfaceFilterTest, OnOneSurfaceItIsTheMeanOfTheWindow) {
  Image one(kSize, kSize, 1);
  one.at(8, 8, 0) = 1;
  const Image filtered = FilterAlongSurfaces(one, Floor(), 1);
  for (int y = 7; y <= 9; ++y) {
    for (int x = 7; x <= 9; ++x) EXPECT_FLOAT_EQ(filtered.at(x, y, 0), 1.0f / 9);
  }
  EXPECT_EQ(filtered.at(6, 8, 0), 0);
  // Noise of n pixels is n^-1/2 of one's.
  EXPECT_NEAR(Deviation(FilterAlongSurfaces(Noise(), Floor(), 2)), 0.5 / 5, 0.03);
}

TEST(SurfaceFilterTest, StepsWallsAndTheVoidAreEdges) {
  Image left(kSize, kSize, 1);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < 8; ++x) left.at(x, y, 0) = 1;
  }
  Surfaces step = Floor(), wall = Floor(), nothing = Floor();
  for (int i = 0; i < kSize * kSize; ++i) {
    if (i % kSize < 8) continue;
    step.points[i].y = 1;
    wall.normals[i] = {-1, 0, 0};
    nothing.normals[i] = {0, 0, 0};
  }
  for (const Surfaces& surfaces : {step, wall, nothing}) {
    const Image filtered = FilterAlongSurfaces(left, surfaces, 1);
    for (size_t i = 0; i < left.size(); ++i) EXPECT_EQ(filtered.data()[i], left.data()[i]) << i;
  }
  EXPECT_NE(FilterAlongSurfaces(left, Floor(), 1).at(8, 8, 0), 0);
}

}  // namespace
}  // namespace halfshade
