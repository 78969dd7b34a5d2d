// alphaMode MASK, for the camera and in shadow maps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/renderer/shade/shade_fixture.h"

namespace halfshade {
namespace {

constexpr uint32_t kTexels = 8;

// A checkerboard of holes: alpha 255 where column + row is even.
Rgba Checker() {
  Rgba texels;
  for (uint32_t y = 0; y < kTexels; ++y) {
    for (uint32_t x = 0; x < kTexels; ++x) {
      for (const int value : {255, 255, 255, (x + y) % 2 == 0 ? 255 : 0}) texels.push_back(uint8_t(value));
    }
  }
  return texels;
}

bool IsLeaf(double u, double v) {
  if (u < 0 || u >= 1 || v < 0 || v >= 1) return false;
  return (int(u * kTexels) + int(v * kTexels)) % 2 == 0;
}

// A checkered plate of edge 1 at height 1, over a plain one of edge 8.
FlatScene CheckerOverGround() {
  GlbMesh leaf = MakePlate({0, 1, 0}, 1, 1);
  for (const glm::vec3& p : leaf.positions) leaf.texcoords.emplace_back(p.x + 0.5f, p.z + 0.5f);
  FlatScene scene = MakeFlatScene({leaf, MakePlate({0, 0, 0}, 8, 8)});
  scene.materials[0].alpha_mode = AlphaMode::kMask;
  scene.materials[0].base_color_texture.texture = AddTexture(&scene, kTexels, kTexels, Checker());
  return scene;
}

// From between the two, down on the ground.
RenderRequest GroundRequest(int n = 256) {
  RenderRequest request = LookDownOn(4, n);
  request.camera = LookDown(0.5, 4);
  request.lights = {LightAbove(2, 0)};
  request.method = HardOptions{1024};
  request.outputs = {OutputKind::kVisibility};
  return request;
}

double World(int pixel, int n, double size) { return ((pixel + 0.5) / n - 0.5) * size; }

class MasksTest : public ShadeTest {
 protected:
  // Pixels of the ground whose visibility is not the checkerboard's shadow from a point at height 2: twice its size.
  int WrongPixels(const Image& v, double* share_dark) {
    const int n = v.width();
    int wrong = 0, dark = 0;
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const bool is_dark = IsLeaf(World(x, n, 4) / 2 + 0.5, World(y, n, 4) / 2 + 0.5);
        dark += is_dark;
        wrong += (v.at(x, y, 0) == 0) != is_dark;
      }
    }
    *share_dark = double(dark) / (n * n);
    return wrong;
  }
};

TEST_F(MasksTest, HolesLetTheLightThroughToTheTexel) {
  for (const MethodOptions& method :
       {MethodOptions(HardOptions{1024}), MethodOptions(RayOptions{1}), MethodOptions(ShaftOptions{8})}) {
    RenderRequest request = GroundRequest();
    request.method = method;
    const std::vector<RenderedImage> images = Render(CheckerOverGround(), request);
    ASSERT_EQ(images.size(), 1u);
    double dark = 0;
    const int wrong = WrongPixels(images[0].image, &dark);
    EXPECT_NEAR(dark, 0.125, 1e-3);
    // Silhouettes are 2 x 9 lines of 128 pixels at most; a pixel is 8 texels of the map, so one pixel in 8 along them
    // may be on the other side. Measured: 0, by rays too.
    EXPECT_LE(wrong, 2 * 9 * 128 / 8);
  }
}

// Wrapped, in between texels, by the second texture coordinate's twin on the CPU: rays, shafts and maps see the same
// leaves.
TEST_F(MasksTest, RaysShaftsAndMapsSeeTheSameMask) {
  for (const Wrap wrap : {Wrap::kRepeat, Wrap::kMirroredRepeat, Wrap::kClampToEdge}) {
    for (const bool is_nearest : {false, true}) {
      FlatScene scene = CheckerOverGround();
      scene.textures[0].wrap_s = scene.textures[0].wrap_t = wrap;
      scene.textures[0].magnifies_to_nearest = is_nearest;
      for (glm::vec2& texcoord : scene.texcoords) texcoord = texcoord * 2.5f - 1.3f;
      RenderRequest request = GroundRequest(128);
      request.method = HardOptions{2048};
      const std::vector<RenderedImage> map = Render(scene, request);
      for (const MethodOptions& method : {MethodOptions(RayOptions{1}), MethodOptions(ShaftOptions{8})}) {
        request.method = method;
        const std::vector<RenderedImage> other = Render(scene, request);
        ASSERT_EQ(map.size() + other.size(), 2u);
        int different = 0, dark = 0;
        for (size_t i = 0; i < other[0].image.size(); ++i) {
          different += map[0].image.data()[i] != other[0].image.data()[i];
          dark += other[0].image.data()[i] == 0;
        }
        EXPECT_GT(dark, 500);
        // 2 x 21 edges of 64 pixels, of which a map's texel is a tenth.
        EXPECT_LE(different, 2 * 21 * 64 / 10) << int(wrap) << is_nearest << method.index();
      }
    }
  }
}

TEST_F(MasksTest, ASoftShadowIsTheMeanOfTheHoles) {
  RenderRequest request = GroundRequest(64);
  request.lights = {LightAbove(2, 1)};  // as wide as 4 periods seen from the ground
  // Half of the plate is holes. 64 samples, stratified; 1024.
  for (const auto& [method, most] :
       {std::pair{MethodOptions(MultiMapOptions{64, 512}), 0.07}, std::pair{MethodOptions(ShaftOptions{32}), 0.01}}) {
    request.method = method;
    const std::vector<RenderedImage> images = Render(CheckerOverGround(), request);
    ASSERT_EQ(images.size(), 1u);
    EXPECT_NEAR(images[0].image.at(32, 32, 0), 0.5, most) << method.index();
  }
}

TEST_F(MasksTest, TheCameraSeesThroughHoles) {
  FlatScene scene = CheckerOverGround();
  scene.materials[0].emissive = glm::vec3(1);
  RenderRequest request = LookDownOn(1, 64);
  const Image frame = RenderFrame(scene, request);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      EXPECT_EQ(frame.at(x, y, 0), IsLeaf((x + 0.5) / 64, (y + 0.5) / 64) ? 1 : 0) << x << " " << y;
    }
  }
}

TEST_F(MasksTest, AlphaIsTheProductOfFactorTextureAndVertex) {
  // The leaf's alpha is 1 in the texture: what is left is .75 x .5.
  const auto share_hidden = [&](float cutoff) {
    FlatScene scene = CheckerOverGround();
    scene.materials[0].base_color.a = 0.75f;
    scene.materials[0].alpha_cutoff = cutoff;
    scene.colors.assign(scene.positions.size(), {1, 1, 1, 0.5f});
    const Image v = Render(scene, GroundRequest(64))[0].image;
    int hidden = 0;
    for (size_t i = 0; i < v.size(); ++i) hidden += v.data()[i] == 0;
    return double(hidden) / double(v.size());
  };
  EXPECT_NEAR(share_hidden(0.37f), 0.125, 0.01);
  EXPECT_EQ(share_hidden(0.38f), 0);
}

// The camera's rule of BLEND: as a MASK of one half. Light has another (blend_gl_test).
TEST_F(MasksTest, BlendIsAMaskOfOneHalfForTheCamera) {
  const auto scene_of = [](AlphaMode mode, std::initializer_list<int> leaves, std::initializer_list<int> holes) {
    FlatScene scene = CheckerOverGround();
    Rgba texels = Checker();
    for (size_t i = 0; i < texels.size() / 4; ++i) {
      const auto& alphas = texels[4 * i + 3] == 255 ? leaves : holes;
      texels[4 * i + 3] = uint8_t(alphas.begin()[i / 2 % alphas.size()]);
    }
    scene.materials[0].base_color_texture.texture = AddTexture(&scene, kTexels, kTexels, texels);
    scene.textures.back().magnifies_to_nearest = true;
    scene.materials[0].alpha_mode = mode;
    scene.materials[0].emissive = glm::vec3(1);
    return scene;
  };
  const FlatScene blend = scene_of(AlphaMode::kBlend, {128, 255, 192}, {127, 0, 64});
  const FlatScene mask = scene_of(AlphaMode::kMask, {255}, {0});
  const Image seen = RenderFrame(blend, LookDownOn(1, 64)), expected = RenderFrame(mask, LookDownOn(1, 64));
  EXPECT_TRUE(std::equal(seen.data(), seen.data() + seen.size(), expected.data()));
  EXPECT_GT(*std::max_element(seen.data(), seen.data() + seen.size()), 0);
}

TEST_F(MasksTest, WithoutATextureTheFactorDecidesAlone) {
  for (const float cutoff : {0.5f, 0.51f}) {
    FlatScene scene = CheckerOverGround();
    scene.materials[0].base_color_texture.texture = -1;
    scene.materials[0].base_color.a = 0.5f;
    scene.materials[0].alpha_cutoff = cutoff;
    EXPECT_EQ(scene.CoverageOf(scene.meshes[0]), cutoff == 0.5f ? MaskCoverage::kFull : MaskCoverage::kNothing);
    const Image v = Render(scene, GroundRequest(64))[0].image;
    EXPECT_EQ(v.at(32, 32, 0), cutoff == 0.5f ? 0 : 1);
    EXPECT_TRUE(decoded().empty());
  }
}

TEST_F(MasksTest, VisibilityDecodesNothingButMasks) {
  FlatScene scene = CheckerOverGround();
  scene.materials[1].base_color_texture.texture = AddTexture(&scene, 1, 1, {255, 255, 255, 255});
  scene.materials[0].normal_texture.texture = AddTexture(&scene, 1, 1, {128, 128, 255, 255});
  Render(scene, GroundRequest(16));
  EXPECT_EQ(decoded(), std::vector<std::string>{"/images/0"});
  scene.materials[0].alpha_mode = AlphaMode::kOpaque;
  Render(scene, GroundRequest(16));
  EXPECT_TRUE(decoded().empty());
  bool is_skipped = false;
  for (const PassReport& pass : report().passes)
    is_skipped = is_skipped || (pass.name == "textures" && pass.is_skipped);
  EXPECT_TRUE(is_skipped);
}

TEST_F(MasksTest, AFrameDecodesEveryImageOnce) {
  FlatScene scene = CheckerOverGround();
  scene.materials[1].base_color_texture.texture = 0;
  scene.materials[1].occlusion_texture.texture = 0;
  AddTexture(&scene, 1, 1, {1, 2, 3, 4});  // no material's
  RenderFrame(scene, GroundRequest(16));
  EXPECT_EQ(decoded(), std::vector<std::string>{"/images/0"});
}

TEST_F(MasksTest, MasksAndOpaqueMeshesOccludeTogether) {
  // The same plate twice, one of them OPAQUE: the holes are filled.
  FlatScene masked = CheckerOverGround();
  GlbMesh leaf = MakePlate({0, 1, 0}, 1, 1);
  FlatScene scene = MakeFlatScene({leaf, MakePlate({0, 0, 0}, 8, 8), MakePlate({0, 0.9, 0}, 0.9, 0.9)});
  scene.texcoords = masked.texcoords;
  scene.texcoords.resize(scene.positions.size());
  scene.images = masked.images;
  scene.textures = masked.textures;
  scene.materials[0] = masked.materials[0];
  const Image v = Render(scene, GroundRequest(64))[0].image;
  for (int y = 24; y < 40; ++y) {
    for (int x = 24; x < 40; ++x) EXPECT_EQ(v.at(x, y, 0), 0);
  }
}

}  // namespace
}  // namespace halfshade
