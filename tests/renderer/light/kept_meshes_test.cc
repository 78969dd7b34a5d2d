#include "renderer/light/kept_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/light/occluders.h"
#include "renderer/math/light_frame.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

constexpr uint32_t kTriangles = 512;
constexpr size_t kLeastPlaces = 8;

GlbMesh Ball(uint32_t triangles = kTriangles) {
  GlbMesh ball = MakeSphere({0, 0, 0}, 0.1, 80);
  ball.indices.resize(3 * triangles);
  // Its vertices are those of the triangles that are left.
  const size_t vertices = *std::max_element(ball.indices.begin(), ball.indices.end()) + 1;
  ball.positions.resize(vertices);
  if (!ball.normals.empty()) ball.normals.resize(vertices);
  return ball;
}

FlatScene Balls(size_t count, const glm::dmat4& first_place = glm::dmat4(1), uint32_t triangles = kTriangles) {
  FlatScene scene = MakeFlatScene({Ball(triangles)});
  const Node node = scene.nodes[0];
  for (size_t i = 1; i < count; ++i) {
    scene.scenes[0].roots.push_back(uint32_t(scene.nodes.size()));
    scene.nodes.push_back(node);
    scene.nodes.back().local = glm::translate(glm::dmat4(1), {double(i), 1.0, 0.5});
  }
  scene.nodes[0].local = glm::translate(glm::dmat4(1), {0.0, 1.0, 0.0}) * first_place;
  return scene;
}

KeptPlaces Find(const FlatScene& scene, const std::vector<NodeOverride>& overrides = {}) {
  return FindKeptPlaces(scene, *BuildPose(scene, 0, overrides), FindKeptMeshes(scene), LightAbove(3, 0.5));
}

size_t CountElsewhere(const KeptPlaces& found) {
  const std::vector<bool>& there = found.elsewhere.stands_there;
  return size_t(std::count(there.begin(), there.end(), true));
}

TEST(KeptMeshesTest, WhatHasManyTrianglesAtAllItsPlacesIsKept) {
  static_assert(kTriangles * kLeastPlaces == kLeastTrianglesOfAll);
  EXPECT_EQ(FindKeptMeshes(Balls(kLeastPlaces - 1)), std::vector<uint32_t>{kNotKept});
  EXPECT_EQ(FindKeptMeshes(Balls(kLeastPlaces)), std::vector<uint32_t>{0});
  EXPECT_EQ(FindKeptMeshes(MakeFlatScene({Ball(kLeastTrianglesOfAll - 1)})), std::vector<uint32_t>{kNotKept});
  EXPECT_EQ(FindKeptMeshes(MakeFlatScene({Ball(kLeastTrianglesOfAll)})), std::vector<uint32_t>{0});
  const glm::dmat4 here(1);
  EXPECT_EQ(FindKeptMeshes(Balls(1000, here, kLeastKeptTriangles - 1)), std::vector<uint32_t>{kNotKept});
  EXPECT_EQ(FindKeptMeshes(Balls(1000, here, kLeastKeptTriangles)), std::vector<uint32_t>{0});
}

TEST(KeptMeshesTest, EveryPlaceOfANodeCounts) {
  FlatScene scene = Balls(1);
  ASSERT_EQ(FindKeptMeshes(scene), std::vector<uint32_t>{kNotKept});
  scene.nodes[0].place_count = kLeastPlaces;
  EXPECT_EQ(FindKeptMeshes(scene), std::vector<uint32_t>{0});
}

TEST(KeptMeshesTest, MeshesWithTheSameTrianglesAreOneWhateverTheirMaterials) {
  std::vector<GlbMesh> meshes(kLeastPlaces, Ball());
  for (size_t i = 0; i < kLeastPlaces; ++i) {
    meshes[i].base_color = {float(i) / kLeastPlaces, 1, 1, 1};
    meshes[i].world_from_mesh = glm::translate(glm::dmat4(1), {double(i), 1.0, 0.0});
  }
  EXPECT_EQ(FindKeptMeshes(MakeFlatScene(meshes)), std::vector<uint32_t>(kLeastPlaces, 0));
  meshes[5].positions[7].x += 1e-4f;  // as many triangles, but not the same
  EXPECT_EQ(FindKeptMeshes(MakeFlatScene(meshes)), std::vector<uint32_t>(kLeastPlaces, kNotKept));
}

TEST(KeptMeshesTest, WhatIsMaskedIsNotKept) {
  FlatScene masked = Balls(kLeastPlaces);
  masked.images.emplace_back();
  masked.textures.emplace_back();
  masked.materials[0].alpha_mode = AlphaMode::kMask;
  masked.materials[0].base_color_texture.texture = 0;
  EXPECT_EQ(FindKeptMeshes(masked), std::vector<uint32_t>{kNotKept});
}

TEST(KeptPlacesTest, APlaceHasTheBoxOfItsCopyToTheBit) {
  const FlatScene scene = Balls(kLeastPlaces, glm::rotate(glm::dmat4(1), 0.7, {1.0, 2.0, 3.0}));
  const KeptPlaces found = Find(scene);
  ASSERT_EQ(found.places.size(), kLeastPlaces);
  const LightSpaceOccluders copies = BuildLightSpaceOccluders(scene, *BuildPose(scene, 0), LightAbove(3, 0.5));
  ASSERT_EQ(copies.runs.size(), kLeastPlaces);
  Box3f all;
  for (size_t i = 0; i < kLeastPlaces; ++i) {
    Box3f box;
    for (uint32_t k = 0; k < copies.runs[i].index_count; ++k) {
      box.Add(copies.positions[copies.indices[copies.runs[i].first_index + k]]);
    }
    EXPECT_EQ(found.places[i].box_ls.min, box.min);
    EXPECT_EQ(found.places[i].box_ls.max, box.max);
    all.Add(box.min);
    all.Add(box.max);
  }
  EXPECT_EQ(found.elsewhere.box_ls.min, all.min);
  EXPECT_EQ(found.elsewhere.box_ls.max, all.max);
  // So nothing is copied, and the hull is as near to the light.
  const LightSpaceOccluders rest =
      BuildLightSpaceOccluders(scene, *BuildPose(scene, 0), LightAbove(3, 0.5), found.elsewhere);
  EXPECT_TRUE(rest.indices.empty());
  EXPECT_EQ(rest.hull.z_near(), copies.hull.z_near());
}

TEST(KeptPlacesTest, WhatStandsBehindTheLightIsGone) {
  for (const double height : {2.89, 2.98, 3.05, 3.11}) {
    FlatScene scene = MakeFlatScene({MakeSphere({0, 0, 0}, 0.1, 40)});
    scene.nodes[0].local = glm::translate(glm::dmat4(1), {0.0, height, 0.0});
    const KeptPlaces found = Find(scene);
    EXPECT_EQ(found.places.size(), height < 3.1 ? 1u : 0u) << height;
    EXPECT_EQ(CountElsewhere(found), 1u);
    const auto z_near = [&](const OccludersElsewhere& elsewhere) {
      return BuildLightSpaceOccluders(scene, *BuildPose(scene, 0), LightAbove(3, 0.5), elsewhere).hull.z_near();
    };
    // Of what crosses the plane the box has also what stands behind it.
    EXPECT_GE(z_near(found.elsewhere), z_near({})) << height;
    EXPECT_LE(z_near(found.elsewhere), (height > 2.9 && height < 3.1 ? 2 : 1) * z_near({})) << height;
  }
}

TEST(KeptPlacesTest, WhatIsSqueezedFlatOrMoreThanSixteenfoldStays) {
  for (const double squeeze : {1.0, -1.0, 1.0 / 16, 1.0 / 18, 0.0}) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 scale(1);
      scale[axis] = squeeze;
      const bool stays = std::abs(squeeze) < 1.0 / 17;
      for (const double size : {1e-3, 1.0}) {  // whatever the size
        const KeptPlaces found = Find(Balls(kLeastPlaces + 1, glm::scale(glm::dmat4(1), size * scale)));
        EXPECT_EQ(found.places.size(), kLeastPlaces + (stays ? 0 : 1)) << squeeze << " along " << axis;
        EXPECT_EQ(CountElsewhere(found), found.places.size());
      }
    }
  }
}

TEST(KeptPlacesTest, WhatDoesNotCastIsNotThere) {
  NodeOverride override;
  override.node = 3;
  override.casts = false;
  const KeptPlaces found = Find(Balls(kLeastPlaces + 1), {override});
  EXPECT_EQ(found.places.size(), kLeastPlaces);
  EXPECT_EQ(CountElsewhere(found), kLeastPlaces);
}

}  // namespace
}  // namespace halfshade
