#include "renderer/light/receiver_tile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "renderer/math/light_frame.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

// Pixels of a camera that looks at the plane y = 0; every seventh does not receive.
CpuReceivers PixelsOnGround(int width, int height) {
  CpuReceivers pixels;
  pixels.camera = LookFrom({3, 2, 1}, {0, 0, 0});
  pixels.width = width;
  pixels.height = height;
  const float below = float(-pixels.camera.eye_ws.y);
  for (int i = 0; i < width * height; ++i) {
    pixels.planes.push_back(i % 7 == 0 ? glm::vec4(0) : glm::vec4(0, 1, 0, below));
  }
  return pixels;
}

TEST(ReceiverTileTest, HoldsEachReceiverOnceWhereTheLightSeesIt) {
  const CpuReceivers pixels = PixelsOnGround(21, 10);  // no whole number of tiles
  const AreaLight light = LightAbove(3, 1, {0.4, 0.2});
  const ReceiverTiles tiles(pixels, light);
  EXPECT_EQ(tiles.count(), 6);
  const LightFrame frame = MakeLightFrame(light);
  const auto tile = std::make_unique<ReceiverTile>();
  std::vector<int> seen(pixels.size());
  for (int t = 0; t < tiles.count(); ++t) {
    tiles.Fill(t, tile.get());
    EXPECT_TRUE(tile->shares_plane);
    EXPECT_TRUE(tile->sees_whole_light);
    for (int i = 0; i < tile->count; ++i) {
      ++seen[tile->index[i]];
      const glm::dvec3 position = PointToLight(frame, pixels.At(tile->index[i]).position_ws);
      EXPECT_NEAR(tile->w[i], 1 / position.z, 1e-12);
      EXPECT_NEAR(tile->u[i], position.x / position.z, 1e-9);
      EXPECT_NEAR(tile->v[i], position.y / position.z, 1e-9);
      EXPECT_NEAR(tile->height[i], 3, 1e-6);
      EXPECT_NEAR(tile->normal_z[i], -1, 1e-6);
      EXPECT_GE(tile->u[i], tile->slope_low.x);
      EXPECT_LE(tile->v[i], tile->slope_high.y);
      EXPECT_LE(tile->w_low, tile->w[i]);
      EXPECT_GE(tile->w_high, tile->w[i]);
    }
  }
  for (size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i], i % 7 == 0 ? 0 : 1) << i;
}

TEST(ReceiverTileTest, WhatStandsBehindTheLightIsLeftOut) {
  const CpuReceivers pixels = PixelsOnGround(8, 8);
  const ReceiverTiles tiles(pixels, LightAbove(-1, 1));  // shines down from below
  const auto tile = std::make_unique<ReceiverTile>();
  tiles.Fill(0, tile.get());
  EXPECT_EQ(tile->count, 0);
}

TEST(ReceiverTileTest, PointsWithoutANormalHaveTheWholeLightAbove) {
  const CpuReceivers points = MakePointReceivers({{0, 0, 0}, {0.5, 1, 0.25}}, {});
  const ReceiverTiles tiles(points, LightAbove(3, 1));
  const auto tile = std::make_unique<ReceiverTile>();
  tiles.Fill(0, tile.get());
  ASSERT_EQ(tile->count, 2);
  EXPECT_TRUE(tile->sees_whole_light);
  EXPECT_NEAR(tile->w[1], 0.5, 1e-7);
  EXPECT_NEAR(std::abs(tile->u[1]), 0.25, 1e-7);
}

TEST(ReceiverTileTest, AWallBesideTheLightDoesNotSeeAllOfIt) {
  const CpuReceivers point = MakePointReceivers({{0.2, 0, 0}}, {{1, 0, 0}});
  const ReceiverTiles tiles(point, LightAbove(3, 1));
  const auto tile = std::make_unique<ReceiverTile>();
  tiles.Fill(0, tile.get());
  ASSERT_EQ(tile->count, 1);
  EXPECT_FALSE(tile->sees_whole_light);
}

}  // namespace
}  // namespace halfshade
