#include "renderer/shadow/shaft/tile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <vector>

#include "renderer/scene/pose.h"
#include "tests/renderer/shadow/shaft/resolve_points.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/mesh_parts.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

const AreaLight kLight = LightAbove(3, 0.5);
const ShaftSpace kSpace = {.scale = {2, 2, 2}};

// 256 receivers in turns around the places, `size` apart.
std::vector<glm::vec3> PointsAround(const std::vector<glm::vec3>& places, float size) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < Tile::kMost; ++i) {
    const glm::vec3 offset(float(i % 16) / 15 - 0.5f, 0, float(i / 16) / 15 - 0.5f);
    points.push_back(places[size_t(i) % places.size()] + offset * size);
  }
  return points;
}

Tile TileOf(const std::vector<glm::vec3>& points) {
  const CpuReceivers receivers = OnGround(points);
  Tile tile;
  EXPECT_TRUE(TileFiller(receivers, kLight, kSpace, 0).Fill(0, &tile));
  return tile;
}

int ActiveCount(const Tile& tile) {
  int count = 0;
  for (const uint32_t lanes : tile.active) count += std::popcount(lanes);
  return count;
}

float ExtentOf(const Tile& tile) {
  const auto [low, high] = std::minmax_element(tile.x, tile.x + Tile::kMost);
  return *high - *low;
}

TEST(SplitTileTest, WhatStandsApartIsATileOfItsOwnAndNoReceiverIsLostOrDoubled) {
  const std::vector<glm::vec3> points = PointsAround({{-1, 0, 0}, {1, 0.5, 0}}, 0.1f);
  Tile tile = TileOf(points);
  const Tile whole = tile;
  std::vector<Tile> apart;
  SplitTile(&tile, &apart);
  ASSERT_EQ(apart.size(), 1u);
  EXPECT_EQ(ActiveCount(tile), 128);
  EXPECT_GT(ExtentOf(whole), 4);
  EXPECT_FALSE(whole.shares_one_plane);
  for (const Tile* part : {&tile, &apart[0]}) {
    EXPECT_LE(ExtentOf(*part), 0.201f);  // of .1 m by a light of .5 m, copies in lanes that are not active too
    EXPECT_TRUE(part->shares_one_plane);
  }
  for (int block = 0; block < Tile::kBlocks; ++block) {
    EXPECT_EQ(tile.active[block] | apart[0].active[block], whole.active[block]);
    EXPECT_EQ(tile.active[block] & apart[0].active[block], 0u);
  }
}

TEST(SplitTileTest, OneSurfaceAndASmallTileStayWhole) {
  std::vector<Tile> apart;
  Tile ground = TileOf(PointsAround({{0, 0, 0}}, 4));
  SplitTile(&ground, &apart);
  EXPECT_TRUE(apart.empty());
  // A tenth of the light's edge apart.
  Tile small = TileOf(PointsAround({{0, 0, 0}, {0.05, 0, 0}}, 0.01f));
  SplitTile(&small, &apart);
  EXPECT_TRUE(apart.empty());
  EXPECT_EQ(ActiveCount(small), Tile::kMost);
}

TEST(SplitTileTest, ThereAreAFewPartsAtMost) {
  std::vector<glm::vec3> places;
  for (int i = 0; i < 8; ++i) places.emplace_back(i, 0, 0);
  Tile tile = TileOf(PointsAround(places, 0.1f));
  std::vector<Tile> apart;
  SplitTile(&tile, &apart);
  ASSERT_EQ(apart.size(), kMostApart);
  int count = ActiveCount(tile);
  for (const Tile& part : apart) count += ActiveCount(part);
  EXPECT_EQ(count, Tile::kMost);
}

TEST(SplitTileTest, TheResultIsTheSameOfFewerPolygons) {
  const std::vector<glm::vec3> points = PointsAround({{-1, 0, 0}, {1, 0.5, 0.3}}, 0.4f);
  std::vector<GlbMesh> boxes;
  for (int i = 0; i < 60; ++i) {
    boxes.push_back(MakeBox({-1.5 + 0.05 * i, 1.2 + 0.01 * i, 0.02 * (i % 7)}, {0.03, 0.05, 0.1}));
  }
  const FlatScene scene = MakeFlatScene(boxes);
  MeshShapes none;
  none.kept_meshes.resize(scene.meshes.size(), kNotKept);
  const CpuOccluders occluders = *BuildCpuOccluders(scene, *BuildPose(scene, 0), none.kept_meshes, kLight,
                                                    [](const EncodedImage&) { return Rgba8Image{}; });
  const PolygonTree tree = BuildPolygonTree(occluders, none.shapes, kLight);
  const CpuReceivers receivers = OnGround(points);
  const Resolved split = ResolveTree(tree, occluders.masks, kLight, receivers, 16);

  Tile whole;
  ASSERT_TRUE(TileFiller(receivers, kLight, tree.space, 0).Fill(0, &whole));
  TileScratch scratch;
  TileResult result;
  ResolveTile(tree, occluders.masks, whole, 16, &scratch, &result);
  EXPECT_LT(split.drawn, result.drawn * 3 / 4);
  for (int i = 0; i < Tile::kMost; ++i) ASSERT_EQ(split.hidden[whole.index[i]], result.hidden[i]) << i;
}

TEST(KeepBlocksTest, OthersAreNotActiveAndHaveNoBounds) {
  std::vector<glm::vec3> points = PointsAround({{0, 0, 0}}, 0.1f);
  for (int i = 0; i < Tile::kLanes; ++i) points[size_t(i)].x += 5;  // block 0
  Tile tile = TileOf(points);
  EXPECT_GT(ExtentOf(tile), 5);
  EXPECT_TRUE(KeepBlocks(0xfffe, &tile));
  EXPECT_EQ(ActiveCount(tile), Tile::kMost - Tile::kLanes);
  EXPECT_LT(ExtentOf(tile), 1);
  EXPECT_FALSE(KeepBlocks(1, &tile));
}

}  // namespace
}  // namespace halfshade
