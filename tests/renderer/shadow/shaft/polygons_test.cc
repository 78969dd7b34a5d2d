#include "renderer/shadow/shaft/polygons.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "renderer/scene/pose.h"
#include "renderer/shadow/shaft/polygon_tree.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

// All of it copied.
CpuOccluders Copies(const std::vector<GlbMesh>& meshes, const AreaLight& light) {
  const FlatScene scene = MakeFlatScene(meshes);
  return {BuildLightSpaceOccluders(scene, *BuildPose(scene, 0), light), {}, {}};
}

// Seen from a light at height 3 that shines down.
ShaftPolygons Build(const std::vector<GlbMesh>& meshes, const AreaLight& light = LightAbove(3, 0.5)) {
  return BuildShaftPolygons(Copies(meshes, light), light);
}

PolygonTree BuildTree(const std::vector<GlbMesh>& meshes) {
  const AreaLight light = LightAbove(3, 0.5);
  return BuildPolygonTree(Copies(meshes, light), {}, light);
}

TEST(ShaftPolygonsTest, TheFacesOfABoxAreSixQuadsOfAClosedSurface) {
  const ShaftPolygons polygons = Build({MakeBox({0, 1, 0}, {1, 1, 1})});
  ASSERT_EQ(polygons.polygons.size(), 6u);
  for (const Polygon& polygon : polygons.polygons) {
    EXPECT_EQ(polygon.corners, 4);
    EXPECT_TRUE(polygon.is_closed);
    // The box's middle is behind every face: half a metre.
    const glm::dvec3 middle = polygons.space.FromLight({0, 0, 2});
    const double height = polygon.normal[0] * middle.x + polygon.normal[1] * middle.y + polygon.normal[2] * middle.z;
    EXPECT_NEAR(height - polygon.offset, -0.5, 1e-6);
  }
}

TEST(ShaftPolygonsTest, TheLightIsTheUnitSquareWhateverItsEdges) {
  AreaLight light = LightAbove(3, 0.5);
  light.height_m = 0.25;
  const ShaftPolygons polygons = Build({MakePlate({0, 1, 0}, 1, 1)}, light);
  ASSERT_EQ(polygons.polygons.size(), 1u);
  const Polygon& plate = polygons.polygons[0];
  const auto [low_x, high_x] = std::minmax_element(plate.x, plate.x + 4);
  const auto [low_y, high_y] = std::minmax_element(plate.y, plate.y + 4);
  EXPECT_FLOAT_EQ(*low_x, -0.5f);  // .5 of a metre is one edge from the middle
  EXPECT_FLOAT_EQ(*high_x, 1.5f);
  EXPECT_FLOAT_EQ(*low_y, -1.5f);
  EXPECT_FLOAT_EQ(*high_y, 2.5f);
  EXPECT_FLOAT_EQ(plate.z[0], 4);  // two metres in units of the larger edge
}

TEST(ShaftPolygonsTest, APointIsAThinLightAndNothingIsInfinite) {
  const ShaftPolygons polygons = Build({MakePlate({0, 1, 0}, 1, 1)}, LightAbove(3, 0));
  ASSERT_EQ(polygons.polygons.size(), 1u);
  for (int k = 0; k < 4; ++k) {
    EXPECT_TRUE(std::isfinite(polygons.polygons[0].x[k]));
    EXPECT_TRUE(std::isfinite(polygons.polygons[0].z[k]));
  }
  EXPECT_EQ(polygons.space.scale.x, std::ldexp(1.0, 19));  // the largest coordinate, 2 m, over 2^20
}

TEST(ShaftPolygonsTest, QuadsThatAreBentOrNotConvexStayTwoTriangles) {
  GlbMesh quad = MakePlate({0, 1, 0}, 1, 1);
  ASSERT_EQ(Build({quad}).polygons.size(), 1u);
  GlbMesh bent = quad;
  bent.positions[2].y += 0.01f;
  EXPECT_EQ(Build({bent}).polygons.size(), 2u);
  GlbMesh arrow = quad;  // one corner drawn over the diagonal that it is not on
  const uint32_t other = 6 - arrow.indices[3] - arrow.indices[4] - arrow.indices[5];
  arrow.positions[other] = arrow.positions[other] * 0.2f + arrow.positions[(other + 2) % 4] * 0.8f;
  EXPECT_EQ(Build({arrow}).polygons.size(), 2u);
}

// Three in a plane, of which the middle one is asked for first and could go with either.
TEST(ShaftPolygonsTest, ATriangleIsOfOneQuadOnly) {
  GlbMesh fan;
  fan.positions = {{0, 1, 0}, {1, 1, 0}, {0.5f, 1, 0.8f}, {0.6f, 1, -0.8f}, {1.4f, 1, 0.7f}};
  fan.indices = {0, 2, 1, 0, 1, 3, 1, 2, 4};
  const ShaftPolygons polygons = Build({fan});
  ASSERT_EQ(polygons.polygons.size(), 2u);
  EXPECT_EQ(polygons.polygons[0].corners + polygons.polygons[1].corners, 4 + 3);
}

TEST(ShaftPolygonsTest, WhatCrossesTheLightsPlaneIsCutThereAndOpen) {
  const AreaLight light = LightAbove(3, 0.5);
  const ShaftPolygons polygons = Build({MakeBox({0.2, 3, 0}, {1, 1, 1})}, light);
  EXPECT_EQ(polygons.polygons.size(), 5u);  // without the face behind
  for (const Polygon& polygon : polygons.polygons) {
    EXPECT_FALSE(polygon.is_closed);
    EXPECT_GT(*std::min_element(polygon.z, polygon.z + 4), 0);
    EXPECT_LE(*std::max_element(polygon.z, polygon.z + 4), 1);
  }
}

TEST(PolygonTreeTest, EveryPolygonIsInOneLeafAndWithinItsBoxes) {
  const PolygonTree tree = BuildTree({MakeSphere({0, 1, 0}, 0.5, 40)});
  ASSERT_GT(tree.polygons.size(), 1000u);
  std::vector<int> seen(tree.polygons.size(), 0);
  size_t nodes = 1;
  for (const TreeNode& node : tree.nodes) {
    for (int i = 0; i < TreeNode::kWidth; ++i) {
      if (node.boxes.low[0][i] > node.boxes.high[0][i]) continue;
      if (node.count[i] == 0) ++nodes;
      for (uint32_t p = node.first[i]; p < node.first[i] + node.count[i]; ++p) {
        ++seen[p];
        const Polygon& polygon = tree.polygons[p];
        for (int k = 0; k < polygon.corners; ++k) {
          EXPECT_TRUE(polygon.x[k] >= node.boxes.low[0][i] && polygon.x[k] <= node.boxes.high[0][i]);
          EXPECT_TRUE(polygon.z[k] >= node.boxes.low[2][i] && polygon.z[k] <= node.boxes.high[2][i]);
        }
      }
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), int(seen.size()));
  EXPECT_EQ(nodes, tree.nodes.size());
}

TEST(PolygonTreeTest, NothingIsAnEmptyTree) {
  const PolygonTree tree = BuildTree({MakePlate({0, 5, 0}, 1, 1)});  // behind the light
  EXPECT_TRUE(tree.nodes.empty());
  EXPECT_EQ(tree.SizeBytes(), 0u);
}

}  // namespace
}  // namespace halfshade
