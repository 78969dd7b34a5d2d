#include "renderer/light/occluders.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/scene/blend.h"
#include "tests/support/flat_scene_builder.h"

namespace halfshade {
namespace {

// A square of side 1 at height y, facing up.
GlbMesh Square(float y, float x = 0) {
  GlbMesh mesh;
  mesh.positions = {{x - 0.5f, y, -0.5f}, {x + 0.5f, y, -0.5f}, {x + 0.5f, y, 0.5f}, {x - 0.5f, y, 0.5f}};
  mesh.indices = {0, 2, 1, 0, 3, 2};
  return mesh;
}

AreaLight LightAt(double height) {
  AreaLight light;
  light.center_ws = {0, height, 0};
  light.axis_u_ws = {1, 0, 0};
  light.axis_v_ws = {0, 0, 1};
  light.normal_ws = {0, -1, 0};
  light.width_m = light.height_m = 0.5;
  return light;
}

LightSpaceOccluders Build(const std::vector<GlbMesh>& meshes, const AreaLight& light) {
  const FlatScene scene = MakeFlatScene(meshes);
  return BuildLightSpaceOccluders(scene, *BuildPose(scene, 0), light);
}

TEST(LightSpaceOccludersTest, KeepsOnlyTrianglesWithAPartInFrontOfTheLight) {
  EXPECT_EQ(Build({Square(0), Square(5)}, LightAt(2)).indices.size(), 6u);
  EXPECT_EQ(Build({Square(5)}, LightAt(2)).indices.size(), 0u);
}

TEST(LightSpaceOccludersTest, DepthIsDistanceAlongTheLightsNormal) {
  for (const glm::vec3& p : Build({Square(0.5f)}, LightAt(2)).positions) EXPECT_FLOAT_EQ(p.z, 1.5f);
}

TEST(LightSpaceOccludersTest, NearPlaneIsJustBelowTheNearestOccluder) {
  const double z_near = Build({Square(0), Square(1)}, LightAt(2)).hull.z_near();
  EXPECT_LT(z_near, 1);
  EXPECT_GT(z_near, 0.99);
}

TEST(LightSpaceOccludersTest, ScalingByAPowerOfTwoScalesEveryNumberExactly) {
  const LightSpaceOccluders one = Build({Square(0.1f), Square(0.3f, 0.7f)}, LightAt(2));
  GlbMesh a = Square(0.1f), b = Square(0.3f, 0.7f);
  const float scale = std::ldexp(1.0f, 12);
  for (GlbMesh* mesh : {&a, &b}) {
    for (glm::vec3& p : mesh->positions) p *= scale;
  }
  AreaLight light = LightAt(2.0 * scale);
  light.width_m *= scale;
  light.height_m *= scale;
  const LightSpaceOccluders scaled = Build({a, b}, light);
  ASSERT_EQ(one.positions.size(), scaled.positions.size());
  for (size_t i = 0; i < one.positions.size(); ++i) EXPECT_EQ(one.positions[i] * scale, scaled.positions[i]);
  EXPECT_EQ(one.hull.z_near() * scale, scaled.hull.z_near());
  EXPECT_EQ(one.hull.FrontWindow({0.1, 0}).u1, scaled.hull.FrontWindow({0.1 * scale, 0}).u1);
}

TEST(LightSpaceOccludersTest, FarFromTheOriginNothingIsLost) {
  // The mesh stands 1e6 m away; the light stands over it. Half an ulp of the distance to the light is left as error.
  GlbMesh far = Square(0.25f);
  far.world_from_mesh[3] = glm::dvec4(1e6, 0, 0, 1);
  AreaLight light = LightAt(2);
  light.center_ws.x = 1e6;
  const LightSpaceOccluders here = Build({Square(0.25f)}, LightAt(2));
  const LightSpaceOccluders there = Build({far}, light);
  ASSERT_EQ(here.positions.size(), there.positions.size());
  for (size_t i = 0; i < here.positions.size(); ++i) {
    EXPECT_NEAR(glm::length(here.positions[i] - there.positions[i]), 0, 1e-6);
  }
}

// Masked meshes come last, by material, with their texture coordinates and alpha; those that are all hole not at all.
TEST(LightSpaceOccludersTest, MaskedTrianglesStandLastAndGroupedByMaterial) {
  FlatScene scene = MakeFlatScene({Square(0.1f), Square(0.2f), Square(0.3f), Square(0.4f), Square(0.5f)});
  scene.texcoords.assign(scene.positions.size(), {0.25f, 0.75f});
  scene.textures.resize(1);
  for (const int i : {0, 2, 3, 4}) {
    scene.materials[size_t(i)].alpha_mode = AlphaMode::kMask;
    scene.materials[size_t(i)].base_color_texture.texture = 0;
  }
  scene.materials[0].base_color.a = 0.875f;
  scene.materials[2].base_color.a = 0.125f;  // below the cutoff
  scene.meshes[4].material = 0;
  const LightSpaceOccluders occluders = BuildLightSpaceOccluders(scene, *BuildPose(scene, 0), LightAt(2));
  ASSERT_EQ(occluders.indices.size(), 4 * 6u);
  EXPECT_EQ(occluders.positions.size(), 4 * 4u);
  EXPECT_EQ(occluders.first_masked_vertex, 4u);
  ASSERT_EQ(occluders.masked.size(), 2u);
  EXPECT_EQ(occluders.masked[0].material, 0u);
  EXPECT_EQ(occluders.masked[0].first_index, 6u);
  EXPECT_EQ(occluders.masked[0].index_count, 12u);
  EXPECT_EQ(occluders.masked[1].material, 3u);
  EXPECT_EQ(occluders.masked[1].first_index, 18u);
  EXPECT_EQ(occluders.masked[1].index_count, 6u);
  ASSERT_EQ(occluders.mask_vertices.size(), 12u);
  EXPECT_EQ(occluders.mask_vertices[0], MaskVertex(0.25f, 0.75f, 0.875f));
  EXPECT_EQ(occluders.mask_vertices[11], MaskVertex(0.25f, 0.75f, 1));
  for (size_t i = 6; i < 24; ++i) EXPECT_GE(occluders.indices[i], occluders.first_masked_vertex);
}

// Of every masked vertex where it lies among its instance's cells; scenes without BLEND pay nothing.
TEST(LightSpaceOccludersTest, PlacesOfBlendStandBesideMaskVertices) {
  FlatScene scene = MakeFlatScene({Square(0.1f), Square(0.2f)});
  scene.texcoords.assign(scene.positions.size(), {0.25f, 0.75f});
  scene.textures.resize(1);
  for (size_t i = 0; i < 2; ++i) {
    scene.materials[i].alpha_mode = AlphaMode::kMask;
    scene.materials[i].base_color_texture.texture = 0;
  }
  const Pose pose = *BuildPose(scene, 0);
  EXPECT_TRUE(BuildLightSpaceOccluders(scene, pose, LightAt(2)).blend_places.empty());
  scene.materials[1].alpha_mode = AlphaMode::kBlend;
  const LightSpaceOccluders occluders = BuildLightSpaceOccluders(scene, pose, LightAt(2));
  ASSERT_EQ(occluders.mask_vertices.size(), 8u);
  ASSERT_EQ(occluders.blend_places.size(), 8u);
  const BlendSpace space(scene.meshes[1], pose.instances[1]);
  for (size_t i = 4; i < 8; ++i) EXPECT_EQ(occluders.blend_places[i], space.Place(scene.positions[i]));
}

TEST(LightSpaceOccludersTest, OpaqueScenesPayNothingForMasks) {
  const LightSpaceOccluders occluders = Build({Square(0.1f)}, LightAt(2));
  EXPECT_TRUE(occluders.masked.empty());
  EXPECT_TRUE(occluders.mask_vertices.empty());
}

}  // namespace
}  // namespace halfshade
