#include "renderer/scene/deform.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/scene/animate.h"
#include "renderer/scene/pose.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

// One channel over node 0, which has one morph target.
FlatScene Animated(AnimatedPath path, Interpolation interpolation, uint32_t width, std::vector<float> times,
                   std::vector<float> values) {
  FlatScene scene;
  scene.nodes.resize(1);
  scene.nodes[0].weight_count = 1;
  scene.morph_weights = {0.25f};
  scene.animation_times = std::move(times);
  scene.animation_values = std::move(values);
  scene.channels = {{0, path, interpolation, 0, uint32_t(scene.animation_times.size()), 0, width}};
  scene.animations = {{"", 0, 1, scene.animation_times.back()}};
  Rest rest;
  rest.scale = {2, 2, 2};
  scene.rests = {rest};
  return scene;
}

glm::dvec3 TranslationAt(const FlatScene& scene, double time_s) {
  return glm::dvec3((*Animate(scene, {0, time_s}).overrides[0].local)[3]);
}

TEST(AnimateTest, StepHoldsAndTheEndsHold) {
  const FlatScene scene = Animated(AnimatedPath::kTranslation, Interpolation::kStep, 3, {1, 2}, {5, 0, 0, 7, 0, 0});
  for (const auto& [time_s, x] : std::vector<std::pair<double, double>>{{0, 5}, {1, 5}, {1.999, 5}, {2, 7}, {9, 7}}) {
    EXPECT_EQ(TranslationAt(scene, time_s).x, x) << time_s;
  }
  EXPECT_EQ((*Animate(scene, {0, 0}).overrides[0].local)[0][0], 2) << "what no channel moves is at rest";
}

TEST(AnimateTest, LinearIsTheChord) {
  const FlatScene scene = Animated(AnimatedPath::kTranslation, Interpolation::kLinear, 3, {1, 3}, {5, 1, 0, 7, 2, 0});
  EXPECT_EQ(TranslationAt(scene, 1.5), glm::dvec3(5.5, 1.25, 0));
  EXPECT_EQ(TranslationAt(scene, 0), glm::dvec3(5, 1, 0));
  EXPECT_EQ(TranslationAt(scene, 4), glm::dvec3(7, 2, 0));
}

TEST(AnimateTest, CubicIsThePolynomialThatItsTangentsAreOf) {
  // t^3 - 2 t over [1, 3]: value and derivative at both ends decide a cubic.
  const auto value = [](double t) { return t * t * t - 2 * t; };
  const auto slope = [](double t) { return float(3 * t * t - 2); };
  std::vector<float> values;
  for (const double t : {1.0, 3.0}) {
    for (const float x : {slope(t), float(value(t)), slope(t)}) values.insert(values.end(), {x, 0, 0});
  }
  const FlatScene scene = Animated(AnimatedPath::kTranslation, Interpolation::kCubic, 3, {1, 3}, values);
  for (const double t : {1.0, 1.3, 2.0, 2.9, 3.0}) EXPECT_NEAR(TranslationAt(scene, t).x, value(t), 1e-12) << t;
}

TEST(AnimateTest, RotationsTakeTheShorterArcAtConstantSpeed) {
  const float half = std::sqrt(0.5f);
  // A quarter turn about z, whose end is written with the other sign.
  const FlatScene scene =
      Animated(AnimatedPath::kRotation, Interpolation::kLinear, 4, {0, 1}, {0, 0, 0, 1, 0, 0, -half, -half});
  const glm::dmat4 local = *Animate(scene, {0, 1.0 / 3}).overrides[0].local;
  EXPECT_NEAR(std::atan2(local[0][1], local[0][0]), M_PI / 6, 1e-6);
  EXPECT_NEAR(glm::length(glm::dvec3(local[0])), 2, 1e-9) << "its scale at rest";
}

TEST(AnimateTest, WeightsAreNotOverrides) {
  const FlatScene scene = Animated(AnimatedPath::kWeights, Interpolation::kLinear, 1, {0, 1}, {0, 1});
  const Motion motion = Animate(scene, {0, 0.5});
  EXPECT_TRUE(motion.overrides.empty());
  EXPECT_EQ(motion.morph_weights, std::vector<float>{0.5f});
}

TEST(AnimateTest, WhatTheRequestMovesItselfCounts) {
  NodeOverride animated, hidden, moved;
  animated.local = glm::translate(glm::dmat4(1), {1, 0, 0});
  hidden.casts = false;
  moved.local = glm::translate(glm::dmat4(1), {2, 0, 0});
  EXPECT_EQ(Combine({animated}, {})[0].local, animated.local);
  EXPECT_EQ(Combine({animated}, {moved})[0].local, moved.local);
  const std::vector<NodeOverride> both = Combine({animated}, {hidden});
  ASSERT_EQ(both.size(), 1u);
  EXPECT_EQ(both[0].local, animated.local);
  EXPECT_FALSE(both[0].casts);
}

// A triangle at node 0 with a skin of the nodes 1 and 2, its last vertex shared by both, and one target that lifts the
// first vertex by one.
FlatScene Bendable() {
  FlatScene scene;
  scene.nodes.resize(3);
  scene.nodes[0].skin = 0;
  scene.nodes[0].mesh_count = 1;
  scene.nodes[0].weight_count = 1;
  scene.nodes[0].local = glm::translate(glm::dmat4(1), {1000, 0, 0});  // says nothing of skinned meshes
  scene.scenes = {{"", {0, 1, 2}}};
  scene.morph_weights = {0};
  scene.skins = {{0, 2}};
  scene.skin_joints = {1, 2};
  scene.joint_from_mesh = {glm::mat4(1), glm::mat4(1)};
  scene.bind_vertices = {{{0, 0, 0}, {0, 0, 1}, {}}, {{1, 0, 0}, {0, 0, 1}, {}}, {{0, 1, 0}, {0, 0, 1}, {}}};
  scene.bind_indices = {0, 1, 2};
  scene.influences = {{0, 1}, {1, 0}, {0, 0.25f}, {1, 0}, {0, 0.5f}, {1, 0.5f}};  // the second is not normalized
  scene.morph_deltas = {{{0, 0, 1}, {}, {}}, {}, {}};
  scene.positions.resize(3);
  scene.normals.resize(3);
  scene.texcoords.resize(3);
  scene.indices = {0, 0, 0};
  scene.clusters.resize(1);
  scene.materials.resize(1);
  Mesh mesh;
  mesh.vertex_count = 3;
  scene.meshes = {mesh};
  Deformed deformed;
  deformed.bind_index_count = 3;
  deformed.influence_count = 2;
  deformed.target_count = 1;
  scene.deformed = {deformed};
  return scene;
}

std::vector<glm::dvec3> WorldOf(const FlatScene& scene) {
  std::vector<glm::dvec3> world;
  const Pose pose = *BuildPose(scene, 0);
  for (const glm::vec3& p : scene.positions) {
    world.emplace_back(pose.instances.at(0).world_from_mesh * glm::dvec4(p, 1));
  }
  return world;
}

void ExpectNear(const glm::dvec3& a, const glm::dvec3& b) {
  EXPECT_LT(glm::distance(a, b), 1e-6) << a.x << " " << a.y << " " << a.z;
}

TEST(DeformTest, JointsCarryVerticesByTheirShares) {
  FlatScene scene = Bendable();
  NodeOverride joint;
  joint.node = 2;
  joint.local = glm::translate(glm::dmat4(1), {0, 0, 8});
  ASSERT_OK(Deform({joint}, {0}, &scene));
  const std::vector<glm::dvec3> world = WorldOf(scene);
  ExpectNear(world[0], {0, 0, 0});
  ExpectNear(world[1], {1, 0, 0});
  ExpectNear(world[2], {0, 1, 4});
  EXPECT_EQ(BuildPose(scene, 0)->bounds_ws.max.x, 1) << "the node itself says nothing";
}

TEST(DeformTest, TargetsComeBeforeJoints) {
  FlatScene scene = Bendable();
  NodeOverride joint;
  joint.node = 1;
  joint.local = glm::rotate(glm::dmat4(1), M_PI / 2, {0, 1, 0});  // z to x
  ASSERT_OK(Deform({joint}, {0.5f}, &scene));
  ExpectNear(WorldOf(scene)[0], {0.5, 0, 0});
  ExpectNear(glm::dvec3(scene.normals[0]), {1, 0, 0});
}

TEST(DeformTest, WhatLosesItsAreaIsLeftOutAndComesBack) {
  FlatScene scene = Bendable();
  NodeOverride flat;
  flat.node = 1;
  flat.local = glm::scale(glm::dmat4(1), {1, 0, 1});
  NodeOverride also = flat;
  also.node = 2;
  ASSERT_OK(Deform({flat, also}, {0}, &scene));
  EXPECT_EQ(scene.meshes[0].index_count, 0u);
  EXPECT_TRUE(BuildPose(scene, 0)->instances.empty());
  ASSERT_OK(Deform({}, {0}, &scene));
  EXPECT_EQ(scene.meshes[0].index_count, 3u);
  EXPECT_EQ(scene.clusters[0].triangle_count, 1u);
}

TEST(DeformTest, TooFarIsRefusedWithItsNode) {
  FlatScene scene = Bendable();
  NodeOverride far;
  far.node = 1;
  far.local = glm::translate(glm::dmat4(1), {0.9e18, 0, 0});
  ASSERT_OK(Deform({far}, {0}, &scene));
  far.local = glm::translate(glm::dmat4(1), {1.1e18, 0, 0});
  EXPECT_THAT(Deform({far}, {0}, &scene),
              StatusIs(absl::StatusCode::kInvalidArgument, testing::StartsWith("/nodes/0: its mesh")));
}

TEST(PoseTest, InstancesStandWhereTheirPlacesSay) {
  FlatScene scene = Bendable();
  ASSERT_OK(Deform({}, {0}, &scene));
  scene.nodes[0].skin = -1;
  scene.places = {{{0, 5, 0}, {1, 0, 0, 0}, {2, 2, 2}}, {{0, -5, 0}, glm::quat(0, 0, 0, 1), {1, 1, 1}}};
  scene.nodes[0].place_count = 2;
  const Pose pose = *BuildPose(scene, 0);
  ASSERT_EQ(pose.instances.size(), 2u);
  const auto corner = [&](int i) {
    return glm::dvec3(pose.instances[i].world_from_mesh * glm::dvec4(scene.positions[1], 1));
  };
  ExpectNear(corner(0), {1002, 5, 0});
  ExpectNear(corner(1), {999, -5, 0});  // half a turn about z
  ExpectNear(pose.bounds_ws.max, {1002, 7, 0});
  ExpectNear(pose.bounds_ws.min, {999, -6, 0});
}

}  // namespace
}  // namespace halfshade
