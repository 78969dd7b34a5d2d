// glTF's materials: each part of one, alone, where its value is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/renderer/shade/shade_fixture.h"

namespace halfshade {
namespace {

constexpr float kHalf = 1.0f / 2048;  // a step of the half floats that the G-buffer keeps colours in, and one of 8 bits

class MaterialsTest : public ShadeTest {
 protected:
  // Seen from above under ambient light of 1: the base colour, but for the 4 % and more that every dielectric reflects.
  glm::vec3 Ambient(const FlatScene& scene, int x, int y, int n = 8) {
    RenderRequest request = LookDownOn(2, n);
    request.shading.ambient = glm::vec3(1);
    const Image frame = RenderFrame(scene, request);
    return {frame.at(x, y, 0), frame.at(x, y, 1), frame.at(x, y, 2)};
  }

  // Only what the material emits.
  glm::vec3 Emitted(const FlatScene& scene, int x, int y, int n = 8) {
    const Image frame = RenderFrame(scene, LookDownOn(2, n));
    return {frame.at(x, y, 0), frame.at(x, y, 1), frame.at(x, y, 2)};
  }
};

void ExpectNear(const glm::vec3& value, const glm::vec3& expected, float tolerance = kHalf) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(value[i], expected[i], tolerance) << i;
}

// A plate of edge 2 that emits what its base colour texture, or another, holds.
FlatScene EmissivePlate() {
  FlatScene scene = TexturedPlate(2);
  scene.materials[0].emissive = glm::vec3(1);
  return scene;
}

// Red, green / blue, white.
const Rgba kFour = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255};

TEST_F(MaterialsTest, EmissionIsFactorTimesTextureAndExposed) {
  FlatScene scene = EmissivePlate();
  scene.materials[0].emissive = {0.5f, 0.25f, 1};
  ExpectNear(Emitted(scene, 1, 1), {0.5f, 0.25f, 1});
  scene.materials[0].emissive_texture.texture = AddTexture(&scene, 2, 2, kFour);
  ExpectNear(Emitted(scene, 1, 1), {0.5f, 0, 0});
  ExpectNear(Emitted(scene, 6, 1), {0, 0.25f, 0});
  ExpectNear(Emitted(scene, 1, 6), {0, 0, 1});
  RenderRequest request = LookDownOn(2, 8);
  request.shading.exposure_ev = 2;
  EXPECT_NEAR(RenderFrame(scene, request).at(1, 1, 0), 2, 4 * kHalf);
}

// 188 is .5 in sRGB.
TEST_F(MaterialsTest, ColoursAreSrgbAndOtherTexturesLinear) {
  FlatScene scene = EmissivePlate();
  const int32_t grey = AddTexture(&scene, 1, 1, {188, 188, 188, 255});
  scene.materials[0].emissive_texture.texture = grey;
  ExpectNear(Emitted(scene, 1, 1), glm::vec3(0.5f), 4e-3f);
  // The same image as an occlusion map: .737 of the ambient light.
  scene = TexturedPlate(2);
  const float bright = Ambient(scene, 1, 1).r;
  scene.materials[0].occlusion_texture.texture = AddTexture(&scene, 1, 1, {188, 188, 188, 255});
  ExpectNear(Ambient(scene, 1, 1), glm::vec3(bright * 188 / 255), 2 * kHalf);
  scene.materials[0].occlusion_strength = 0.5f;
  ExpectNear(Ambient(scene, 1, 1), glm::vec3(bright * (1 - 0.5f * (1 - 188 / 255.0f))), 2 * kHalf);
}

TEST_F(MaterialsTest, OcclusionLeavesLightsAlone) {
  FlatScene scene = TexturedPlate(2);
  RenderRequest request = LookDownOn(2, 8);
  request.lights = {LightAbove(3, 1)};
  const Image free = RenderFrame(scene, request);
  scene.materials[0].occlusion_texture.texture = AddTexture(&scene, 1, 1, {0, 0, 0, 255});
  const Image occluded = RenderFrame(scene, request);
  EXPECT_GT(free.at(3, 3, 0), 0.01f);
  EXPECT_EQ(occluded.at(3, 3, 0), free.at(3, 3, 0));
}

// Diffuse under a metal is black: what is left is its tinted reflection.
TEST_F(MaterialsTest, MetallicAndRoughnessComeFromBlueAndGreen) {
  const auto lit = [&](float metallic, float roughness, const Rgba* texel) {
    FlatScene scene = TexturedPlate(2);
    scene.materials[0].metallic = metallic;
    scene.materials[0].roughness = roughness;
    scene.materials[0].base_color = {0.75f, 0.5f, 0.25f, 1};
    if (texel != nullptr) scene.materials[0].metallic_roughness_texture.texture = AddTexture(&scene, 1, 1, *texel);
    RenderRequest request = LookDownOn(2, 8);
    request.lights = {LightAbove(3, 1, {1, 0})};
    const Image frame = RenderFrame(scene, request);
    return glm::vec3(frame.at(2, 4, 0), frame.at(2, 4, 1), frame.at(2, 4, 2));
  };
  const Rgba texel = {17, 128, 51, 99};  // red and alpha say nothing
  ExpectNear(lit(1, 1, &texel), lit(51 / 255.0f, 128 / 255.0f, nullptr), 1e-4f);
  ExpectNear(lit(0.5f, 0.5f, &texel), lit(25.5f / 255, 64 / 255.0f, nullptr), 1e-4f);
  EXPECT_GT(std::abs(lit(1, 1, &texel).r - lit(1, 1, nullptr).r), 1e-3f) << "the test can fail";
}

TEST_F(MaterialsTest, VertexColoursMultiply) {
  FlatScene scene = TexturedPlate(2);
  const glm::vec3 white = Ambient(scene, 3, 3);
  scene.colors.assign(scene.positions.size(), {0.5f, 0.25f, 1, 1});
  const glm::vec3 tinted = Ambient(scene, 3, 3);
  scene.colors.clear();
  scene.materials[0].base_color = {0.5f, 0.25f, 1, 1};
  ExpectNear(tinted, Ambient(scene, 3, 3), 2 * kHalf);
  EXPECT_LT(tinted.g, 0.5f * white.g);
}

TEST_F(MaterialsTest, ATextureMayReadTheSecondCoordinates) {
  FlatScene scene = EmissivePlate();
  scene.texcoords1 = scene.texcoords;
  for (glm::vec2& uv : scene.texcoords1) uv.x = 1 - uv.x;
  scene.materials[0].emissive_texture = {AddTexture(&scene, 2, 2, kFour), 1};
  ExpectNear(Emitted(scene, 1, 1), {0, 1, 0});
  scene.materials[0].emissive_texture.texcoord = 0;
  ExpectNear(Emitted(scene, 1, 1), {1, 0, 0});
}

TEST_F(MaterialsTest, SamplersWrapAndFilterAsTheySay) {
  FlatScene scene = EmissivePlate();
  for (glm::vec2& uv : scene.texcoords) uv = uv * 2.0f;  // twice round
  const auto at = [&](Texture sampling, int x, int y) {
    scene.materials[0].emissive_texture.texture = AddTexture(&scene, 2, 2, kFour, sampling);
    return Emitted(scene, x, y);
  };
  const auto wrapped = [](Wrap s, Wrap t) { return Texture{.wrap_s = s, .wrap_t = t, .magnifies_to_nearest = true}; };
  // Pixel 5 is u = 1.375: the first texel, its mirror, or the last one.
  ExpectNear(at(wrapped(Wrap::kRepeat, Wrap::kRepeat), 4, 1), {1, 0, 0});
  ExpectNear(at(wrapped(Wrap::kMirroredRepeat, Wrap::kRepeat), 4, 1), {0, 1, 0});
  ExpectNear(at(wrapped(Wrap::kClampToEdge, Wrap::kRepeat), 7, 1), {0, 1, 0});
  ExpectNear(at(wrapped(Wrap::kRepeat, Wrap::kClampToEdge), 1, 7), {0, 0, 1});
  ExpectNear(at(wrapped(Wrap::kRepeat, Wrap::kMirroredRepeat), 1, 4), {0, 0, 1});
  // Linear: pixel 3 is u = .4375, three eighths of the way from the first texel's centre to the second's.
  for (glm::vec2& uv : scene.texcoords) uv = uv * 0.5f;
  const glm::vec3 between = at({.wrap_t = Wrap::kClampToEdge}, 3, 0);
  EXPECT_NEAR(between.r, 0.625f, 0.01f);
  EXPECT_NEAR(between.g, 0.375f, 0.01f);
}

TEST_F(MaterialsTest, MipsAreUsedWhereTheSamplerAsksForThem) {
  FlatScene scene = EmissivePlate();
  for (glm::vec2& uv : scene.texcoords) uv = uv * 64.0f;
  const Rgba checker = {255, 255, 255, 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255, 255};
  const auto emitted = [&](MipFilter mips) {
    scene.materials[0].emissive_texture.texture =
        AddTexture(&scene, 2, 2, checker, {.minifies_to_nearest = true, .mip_filter = mips});
    return Emitted(scene, 3, 3).r;
  };
  EXPECT_NEAR(emitted(MipFilter::kLinear), 0.5f, 0.01f);
  EXPECT_NEAR(emitted(MipFilter::kNearest), 0.5f, 0.01f);
  const float nearest = emitted(MipFilter::kNone);
  EXPECT_TRUE(nearest == 0 || nearest == 1) << nearest;
}

// A map that leans toward +u, on a plate with tangents of its own, with none, and mirrored by its node.
TEST_F(MaterialsTest, NormalMapsLeanTheSameWayWithAndWithoutTangents) {
  const Rgba toward_u = {218, 128, 218, 255}, toward_up = {128, 218, 218, 255};
  // How bright a light far along x or z makes the middle.
  const auto lit = [&](const Rgba& texel, glm::dvec3 direction, bool has_tangents, bool is_mirrored) {
    FlatScene scene = TexturedPlate(2);
    scene.materials[0].normal_texture.texture = AddTexture(&scene, 1, 1, texel);
    scene.materials[0].is_double_sided = true;
    // u along x, v along z: the bitangent that maps count along is against v.
    if (has_tangents) scene.tangents.assign(scene.positions.size(), {1, 0, 0, 1});
    if (is_mirrored) scene.nodes[0].local[0][0] = -1;
    RenderRequest request = LookDownOn(1, 8);
    AreaLight light = LightAbove(20, 1);
    light.center_ws = direction * 20.0 + glm::dvec3(0, 20, 0);
    light.normal_ws = -glm::normalize(light.center_ws);
    light.axis_u_ws = glm::normalize(glm::cross(light.normal_ws, glm::dvec3(0.1, 0.2, 0.97)));
    light.axis_v_ws = glm::cross(light.normal_ws, light.axis_u_ws);
    request.lights = {light};
    return RenderFrame(scene, request).at(4, 4, 0);
  };
  const glm::dvec3 x(1, 0, 0), z(0, 0, 1);
  for (const bool has_tangents : {false, true}) {
    EXPECT_GT(lit(toward_u, x, has_tangents, false), 2 * lit(toward_u, -x, has_tangents, false));
    EXPECT_GT(lit(toward_u, -x, has_tangents, true), 2 * lit(toward_u, x, has_tangents, true)) << "mirrored";
    EXPECT_GT(lit(toward_up, -z, has_tangents, false), 2 * lit(toward_up, z, has_tangents, false));
    EXPECT_GT(lit(toward_up, -z, has_tangents, true), 2 * lit(toward_up, z, has_tangents, true)) << "mirrored";
  }
  for (const glm::dvec3& direction : {x, -x, z, -z}) {
    for (const bool is_mirrored : {false, true}) {
      const float derived = lit(toward_u, direction, false, is_mirrored);
      EXPECT_NEAR(lit(toward_u, direction, true, is_mirrored), derived, 1e-3f * derived);
    }
  }
}

TEST_F(MaterialsTest, ANormalMapOfScaleZeroChangesNothing) {
  FlatScene scene = TexturedPlate(2);
  RenderRequest request = LookDownOn(2, 8);
  request.lights = {LightAbove(3, 1, {1, 0})};
  scene.materials[0].occlusion_texture.texture = AddTexture(&scene, 1, 1, {255, 255, 255, 255});  // the same program
  const Image flat = RenderFrame(scene, request);
  scene.materials[0].normal_texture.texture = AddTexture(&scene, 1, 1, {255, 0, 128, 255});
  const Image leaning = RenderFrame(scene, request);
  EXPECT_GT(std::abs(leaning.at(4, 4, 0) - flat.at(4, 4, 0)), 1e-3f);
  scene.materials[0].normal_scale = 0;
  EXPECT_EQ(RenderFrame(scene, request).at(4, 4, 0), flat.at(4, 4, 0));
}

TEST_F(MaterialsTest, OneSidedTrianglesOccludeFromBehind) {
  // A plate that faces down, over another: the camera above looks through it, the light does not.
  FlatScene scene = MakeFlatScene({MakePlate({0, 1, 0}, 1, 1), MakePlate({0, 0, 0}, 8, 8)});
  scene.materials[0].is_double_sided = false;
  std::swap(scene.indices[1], scene.indices[2]);
  std::swap(scene.indices[4], scene.indices[5]);
  RenderRequest request = LookDownOn(4, 16);
  request.lights = {LightAbove(3, 0)};
  request.method = HardOptions{256};
  request.outputs = {OutputKind::kVisibility};
  EXPECT_EQ(Render(scene, request)[0].image.at(8, 8, 0), 0);
}

}  // namespace
}  // namespace halfshade
