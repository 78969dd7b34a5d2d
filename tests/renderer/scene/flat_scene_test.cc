#include "renderer/scene/flat_scene.h"

#include <gtest/gtest.h>

namespace halfshade {
namespace {

TEST(BoxTest, IsEmptyUntilSomethingIsAdded) {
  Box3d box;
  EXPECT_TRUE(box.IsEmpty());
  EXPECT_EQ(box.Extent(), glm::dvec3(0));
  box.Add({1, 2, 3});
  EXPECT_FALSE(box.IsEmpty());
  box.Add({3, 2, 1});
  EXPECT_EQ(box.Center(), glm::dvec3(2));
  EXPECT_EQ(box.Extent(), glm::dvec3(2, 0, 2));
}

TEST(FlatSceneTest, SizeBytesGrowsWithEveryArray) {
  FlatScene scene;
  size_t bytes = scene.SizeBytes();
  const auto grew_by = [&] {
    const size_t before = bytes;
    bytes = scene.SizeBytes();
    return bytes - before;
  };
  scene.positions.resize(10);
  EXPECT_EQ(grew_by(), 120u);
  scene.normals.resize(10);
  EXPECT_EQ(grew_by(), 120u);
  scene.texcoords.resize(10);
  EXPECT_EQ(grew_by(), 80u);
  scene.texcoords1.resize(10);
  EXPECT_EQ(grew_by(), 80u);
  scene.tangents.resize(10);
  EXPECT_EQ(grew_by(), 160u);
  scene.colors.resize(10);
  EXPECT_EQ(grew_by(), 160u);
  scene.indices.resize(10);
  EXPECT_EQ(grew_by(), 40u);
  scene.meshes.resize(1);
  EXPECT_EQ(grew_by(), sizeof(Mesh));
  scene.clusters.resize(1);
  EXPECT_EQ(grew_by(), sizeof(Cluster));
  scene.nodes.resize(1);
  EXPECT_EQ(grew_by(), sizeof(Node));
  scene.nodes[0].name = std::string(1000, 'x');
  EXPECT_GE(grew_by(), 1000u);
  scene.materials.resize(1);
  scene.materials[0].name = std::string(1000, 'x');
  EXPECT_GE(grew_by(), sizeof(Material) + 1000);
  scene.images.resize(1);
  scene.images[0].bytes = std::string(1000, 'x');
  EXPECT_GE(grew_by(), sizeof(EncodedImage) + 1000);
  scene.scenes.resize(1);
  scene.scenes[0].roots.resize(1000);
  EXPECT_GE(grew_by(), sizeof(SceneRoots) + 4000);
  scene.cameras.resize(1);
  scene.cameras[0].name = std::string(1000, 'x');
  EXPECT_GE(grew_by(), sizeof(SceneCamera) + 1000);
  scene.warnings.push_back(std::string(1000, 'x'));
  EXPECT_GE(grew_by(), 1000u);
}

TEST(CoverageTest, MaskIsDecidedWithoutTexelsWhereTheFactorTells) {
  FlatScene scene;
  scene.materials.resize(1);
  Material& material = scene.materials[0];
  const Mesh mesh;
  EXPECT_EQ(scene.CoverageOf(mesh), MaskCoverage::kFull);
  material.alpha_mode = AlphaMode::kBlend;
  material.base_color_texture.texture = 0;
  EXPECT_EQ(scene.CoverageOf(mesh), MaskCoverage::kTested);
  material.alpha_mode = AlphaMode::kMask;
  EXPECT_EQ(scene.CoverageOf(mesh), MaskCoverage::kTested);
  material.alpha_cutoff = 0;
  EXPECT_EQ(scene.CoverageOf(mesh), MaskCoverage::kFull);
  material.alpha_cutoff = 2;
  EXPECT_EQ(scene.CoverageOf(mesh), MaskCoverage::kNothing);
  material.alpha_cutoff = 0.5f;
  material.base_color_texture.texture = -1;
  EXPECT_EQ(scene.CoverageOf(mesh), MaskCoverage::kFull);
  scene.colors.resize(1);
  EXPECT_EQ(scene.CoverageOf(mesh), MaskCoverage::kTested);
  material.base_color.a = 0.25f;
  EXPECT_EQ(scene.CoverageOf(mesh), MaskCoverage::kNothing);
}

// Light meets all of BLEND whose alpha is not 0, and need not ask where it is 1; the camera has a cutoff.
TEST(CoverageTest, BlendIsTestedWhereItsAlphaMayBeBetweenNoneAndAll) {
  FlatScene scene;
  scene.materials.resize(1);
  Material& material = scene.materials[0];
  material.alpha_mode = AlphaMode::kBlend;
  const Mesh mesh;
  struct Case {
    float factor;
    MaskCoverage light, camera, light_of_texture, camera_of_texture;
  };
  constexpr MaskCoverage kFull = MaskCoverage::kFull, kTested = MaskCoverage::kTested,
                         kNothing = MaskCoverage::kNothing;
  for (const Case& it :
       {Case{0, kNothing, kNothing, kNothing, kNothing}, Case{0x1p-20f, kTested, kNothing, kTested, kNothing},
        Case{0.49f, kTested, kNothing, kTested, kNothing}, Case{0.5f, kTested, kFull, kTested, kTested},
        Case{0.99f, kTested, kFull, kTested, kTested}, Case{1, kFull, kFull, kTested, kTested}}) {
    material.base_color.a = it.factor;
    material.base_color_texture.texture = -1;
    EXPECT_EQ(scene.CoverageOf(mesh), it.light) << it.factor;
    EXPECT_EQ(scene.SeenCoverageOf(mesh), it.camera) << it.factor;
    material.base_color_texture.texture = 0;
    EXPECT_EQ(scene.CoverageOf(mesh), it.light_of_texture) << it.factor;
    EXPECT_EQ(scene.SeenCoverageOf(mesh), it.camera_of_texture) << it.factor;
  }
}

}  // namespace
}  // namespace halfshade
