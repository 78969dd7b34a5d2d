#include "renderer/light/shared_meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/light/occluders.h"
#include "renderer/math/light_frame.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

constexpr uint32_t kTriangles = 16384;
constexpr size_t kLeastPlaces = 17;  // all but one save 2^18 triangles

GlbMesh Ball() {
  GlbMesh ball = MakeSphere({0, 0, 0}, 0.1, 80);
  ball.indices.resize(3 * kTriangles);
  return ball;
}

FlatScene Balls(size_t count, const glm::dmat4& first_place = glm::dmat4(1)) {
  FlatScene scene = MakeFlatScene({Ball()});
  const Node node = scene.nodes[0];
  for (size_t i = 1; i < count; ++i) {
    scene.scenes[0].roots.push_back(uint32_t(scene.nodes.size()));
    scene.nodes.push_back(node);
    scene.nodes.back().local = glm::translate(glm::dmat4(1), {double(i), 1.0, 0.5});
  }
  scene.nodes[0].local = glm::translate(glm::dmat4(1), {0.0, 1.0, 0.0}) * first_place;
  return scene;
}

SharedMeshes Find(const FlatScene& scene, const std::vector<NodeOverride>& overrides = {}) {
  return FindSharedMeshes(scene, *BuildPose(scene, 0, overrides), LightAbove(3, 0.5));
}

size_t CountPlaces(const SharedMeshes& found) { return found.meshes.empty() ? 0 : found.meshes[0].places.size(); }

size_t CountCasters(const Pose& pose) {
  size_t count = 0;
  for (const Instance& instance : pose.instances) count += size_t(instance.casts);
  return count;
}

TEST(SharedMeshesTest, OnlyWhatSavesEnoughIsShared) {
  static_assert(kTriangles * (kLeastPlaces - 1) == kLeastSavedTriangles);
  const SharedMeshes few = Find(Balls(kLeastPlaces - 1));
  EXPECT_EQ(CountPlaces(few), 0u);
  EXPECT_EQ(CountCasters(few.rest), kLeastPlaces - 1);
  const SharedMeshes enough = Find(Balls(kLeastPlaces));
  EXPECT_EQ(CountPlaces(enough), kLeastPlaces);
  EXPECT_EQ(CountCasters(enough.rest), 0u);
}

TEST(SharedMeshesTest, APlaceHasTheBoxOfItsCopyToTheBit) {
  const FlatScene scene = Balls(kLeastPlaces, glm::rotate(glm::dmat4(1), 0.7, {1.0, 2.0, 3.0}));
  const SharedMeshes found = Find(scene);
  ASSERT_EQ(CountPlaces(found), kLeastPlaces);
  const LightSpaceOccluders copies = BuildLightSpaceOccluders(scene, *BuildPose(scene, 0), LightAbove(3, 0.5));
  ASSERT_EQ(copies.runs.size(), kLeastPlaces);
  for (size_t i = 0; i < kLeastPlaces; ++i) {
    Box3f box;
    for (uint32_t k = 0; k < copies.runs[i].index_count; ++k) {
      box.Add(copies.positions[copies.indices[copies.runs[i].first_index + k]]);
    }
    EXPECT_EQ(found.meshes[0].places[i].box_ls.min, box.min);
    EXPECT_EQ(found.meshes[0].places[i].box_ls.max, box.max);
    EXPECT_EQ(found.meshes[0].places[i].scale, copies.runs[i].scale);
  }
}

TEST(SharedMeshesTest, MeshesWithTheSameTrianglesAreOneWhateverTheirMaterials) {
  std::vector<GlbMesh> meshes(kLeastPlaces, Ball());
  for (size_t i = 0; i < kLeastPlaces; ++i) {
    meshes[i].base_color = {float(i) / kLeastPlaces, 1, 1, 1};
    meshes[i].world_from_mesh = glm::translate(glm::dmat4(1), {double(i), 1.0, 0.0});
  }
  EXPECT_EQ(CountPlaces(Find(MakeFlatScene(meshes))), kLeastPlaces);
  meshes[5].positions[7].x += 1e-4f;  // as many triangles, but not the same
  EXPECT_EQ(CountPlaces(Find(MakeFlatScene(meshes))), 0u);
}

TEST(SharedMeshesTest, WhatReachesTheLightsPlaneStaysAndWhatStandsBehindItIsGone) {
  for (const double height : {2.89, 2.93, 2.98, 3.2}) {
    const SharedMeshes found = Find(Balls(kLeastPlaces + 1, glm::translate(glm::dmat4(1), {0.0, height - 1, 0.0})));
    const bool is_in_front = height == 2.89, crosses = height == 2.93 || height == 2.98;
    EXPECT_EQ(CountPlaces(found), kLeastPlaces + (is_in_front ? 1 : 0)) << height;
    EXPECT_EQ(CountCasters(found.rest), crosses ? 1u : 0u) << height;
  }
}

TEST(SharedMeshesTest, WhatIsSqueezedFlatOrMoreThanSixteenfoldStays) {
  for (const double squeeze : {1.0, -1.0, 1.0 / 16, 1.0 / 18, 0.0}) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 scale(1);
      scale[axis] = squeeze;
      const bool stays = std::abs(squeeze) < 1.0 / 17;
      for (const double size : {1e-3, 1.0}) {  // whatever the size
        const SharedMeshes found = Find(Balls(kLeastPlaces + 1, glm::scale(glm::dmat4(1), size * scale)));
        EXPECT_EQ(CountPlaces(found), kLeastPlaces + (stays ? 0 : 1)) << squeeze << " along " << axis;
        EXPECT_EQ(CountCasters(found.rest), stays ? 1u : 0u);
      }
    }
  }
}

TEST(SharedMeshesTest, WhatDoesNotCastAndWhatIsMaskedIsNotShared) {
  NodeOverride override;
  override.node = 3;
  override.casts = false;
  const SharedMeshes found = Find(Balls(kLeastPlaces + 1), {override});
  EXPECT_EQ(CountPlaces(found), kLeastPlaces);
  EXPECT_EQ(CountCasters(found.rest), 0u);

  FlatScene masked = Balls(kLeastPlaces);
  masked.images.emplace_back();
  masked.textures.emplace_back();
  masked.materials[0].alpha_mode = AlphaMode::kMask;
  masked.materials[0].base_color_texture.texture = 0;
  const SharedMeshes of_masked = Find(masked);
  EXPECT_EQ(CountPlaces(of_masked), 0u);
  EXPECT_EQ(CountCasters(of_masked.rest), kLeastPlaces);
}

}  // namespace
}  // namespace halfshade
