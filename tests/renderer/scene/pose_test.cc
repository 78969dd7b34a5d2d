#include "renderer/scene/pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

// One triangle around `origin` under node 0, which hangs below node 1.
FlatScene OneTriangle(const glm::dvec3& origin) {
  FlatScene scene;
  scene.positions = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  scene.indices = {0, 1, 2};
  Mesh mesh;
  mesh.origin = origin;
  mesh.vertex_count = 3;
  mesh.index_count = 3;
  for (const glm::vec3& p : scene.positions) mesh.bounds.Add(p);
  scene.meshes = {mesh};
  Node child, parent;
  child.parent = 1;
  child.mesh_count = 1;
  scene.nodes = {child, parent};
  scene.scenes = {{"", {1}}, {"empty", {}}};
  return scene;
}

TEST(PoseTest, TheOriginIsFoldedIn) {
  FlatScene scene = OneTriangle({5, 6, 7});
  scene.nodes[1].local = glm::translate(glm::dmat4(1), {100, 0, 0});
  const auto pose = BuildPose(scene, 0);
  ASSERT_OK(pose);
  ASSERT_EQ(pose->instances.size(), 1u);
  EXPECT_EQ(pose->instances[0].node, 0u);
  EXPECT_EQ(glm::dvec3(pose->instances[0].world_from_mesh * glm::dvec4(0, 1, 0, 1)), glm::dvec3(105, 7, 7));
  EXPECT_EQ(pose->bounds_ws.min, glm::dvec3(104, 6, 7));
  EXPECT_EQ(pose->bounds_ws.max, glm::dvec3(106, 7, 7));
}

TEST(PoseTest, BoundsAreOfTheVerticesNotOfTheTurnedBox) {
  FlatScene scene = OneTriangle({0, 0, 0});
  scene.nodes[0].local = glm::rotate(glm::dmat4(1), glm::radians(45.0), {0, 0, 1});
  const auto pose = BuildPose(scene, 0);
  ASSERT_OK(pose);
  const double half = std::sqrt(0.5);
  EXPECT_NEAR(pose->bounds_ws.max.x, half, 1e-15) << "the turned box reaches 2 half";
  EXPECT_NEAR(pose->bounds_ws.max.y, half, 1e-15);
  EXPECT_NEAR(pose->bounds_ws.min.y, -half, 1e-15);
}

TEST(PoseTest, AThousandKilometresAwayNoMicrometreIsLost) {
  FlatScene scene = OneTriangle({1e6, 0, 0});
  scene.nodes[0].local = glm::translate(glm::dmat4(1), {-1e6, 0, 0});
  scene.positions[1].x = 1 + 1e-6f;
  EXPECT_NEAR(BuildPose(scene, 0)->bounds_ws.max.x, 1 + 1e-6f, 1e-9) << "as a float it would be 1";
}

TEST(PoseTest, InstancesComeInTheOrderOfTheGraph) {
  FlatScene scene = OneTriangle({0, 0, 0});
  Node sibling;
  sibling.parent = 1;
  sibling.mesh_count = 1;
  scene.nodes.push_back(sibling);
  scene.nodes[1].mesh_count = 1;
  const auto pose = BuildPose(scene, 0);
  ASSERT_OK(pose);
  std::vector<uint32_t> nodes;
  for (const Instance& instance : pose->instances) nodes.push_back(instance.node);
  EXPECT_THAT(nodes, testing::ElementsAre(1, 0, 2));
}

TEST(PoseTest, AnEmptySceneHasNeitherInstancesNorBounds) {
  const auto pose = BuildPose(OneTriangle({0, 0, 0}), 1);
  ASSERT_OK(pose);
  EXPECT_TRUE(pose->instances.empty());
  EXPECT_TRUE(pose->bounds_ws.IsEmpty());
}

TEST(PoseTest, AnUnknownSceneIsRefusedWithBothNumbers) {
  EXPECT_THAT(BuildPose(OneTriangle({0, 0, 0}), 3),
              StatusIs(absl::StatusCode::kInvalidArgument, "scene_index: 3; the scene has 2"));
}

// Node 0 below node 1.
NodeOverride Change(uint32_t node) {
  NodeOverride change;
  change.node = node;
  return change;
}

TEST(PoseTest, AnOverrideReplacesTheLocalMatrixAndMovesWhatIsBelow) {
  FlatScene scene = OneTriangle({0, 0, 0});
  scene.nodes[0].local = glm::translate(glm::dmat4(1), {1, 0, 0});
  scene.nodes[1].local = glm::translate(glm::dmat4(1), {10, 0, 0});
  NodeOverride change = Change(1);
  change.local = glm::translate(glm::dmat4(1), {0, 5, 0});
  const auto pose = BuildPose(scene, 0, {change});
  ASSERT_OK(pose);
  EXPECT_EQ(glm::dvec3(pose->instances[0].world_from_mesh[3]), glm::dvec3(1, 5, 0));
  EXPECT_EQ(pose->bounds_ws.max, glm::dvec3(2, 6, 0));
  EXPECT_EQ(glm::dvec3(WorldFromNode(scene, 0, {change})[3]), glm::dvec3(1, 5, 0));
}

TEST(PoseTest, WhereAMeshIsMovedTooFarItsNodeIsNamed) {
  const FlatScene scene = OneTriangle({0, 0, 0});
  NodeOverride far;
  far.node = 1;
  far.local = glm::translate(glm::dmat4(1), {9e17, 0, 0});
  EXPECT_OK(BuildPose(scene, 0, {far}));
  for (const double x : {1.1e18, HUGE_VAL, double(NAN)}) {
    far.local = glm::translate(glm::dmat4(1), {x, 0, 0});
    EXPECT_THAT(BuildPose(scene, 0, {far}),
                StatusIs(absl::StatusCode::kInvalidArgument, "/nodes/0: its mesh reaches over 1e18 m away"));
  }
}

TEST(PoseTest, WhatANodeDoesNotDoNothingBelowItDoes) {
  const FlatScene scene = OneTriangle({0, 0, 0});
  for (const auto member : {&NodeOverride::is_visible, &NodeOverride::casts, &NodeOverride::receives}) {
    for (const uint32_t node : {0u, 1u}) {
      NodeOverride change = Change(node);
      change.*member = false;
      const auto pose = BuildPose(scene, 0, {change, Change(1 - node)});
      ASSERT_OK(pose);
      ASSERT_EQ(pose->instances.size(), 1u);
      const Instance& instance = pose->instances[0];
      EXPECT_EQ(instance.is_visible, change.is_visible);
      EXPECT_EQ(instance.casts, change.casts);
      EXPECT_EQ(instance.receives, change.receives);
      EXPECT_EQ(pose->bounds_ws.IsEmpty(), !change.is_visible) << "the picture is framed by what is drawn";
    }
  }
}

TEST(PoseTest, WhatIsNeitherDrawnNorCastsIsLeftOut) {
  NodeOverride change = Change(1);
  change.is_visible = change.casts = false;
  EXPECT_TRUE(BuildPose(OneTriangle({0, 0, 0}), 0, {change})->instances.empty());
}

TEST(WorldFromNodeTest, IsTheProductOfTheAncestors) {
  FlatScene scene = OneTriangle({0, 0, 0});
  scene.nodes[0].local = glm::translate(glm::dmat4(1), {1, 0, 0});
  scene.nodes[1].local = glm::scale(glm::dmat4(1), {2, 2, 2});
  EXPECT_EQ(glm::dvec3(WorldFromNode(scene, 0)[3]), glm::dvec3(2, 0, 0));
}

}  // namespace
}  // namespace halfshade
