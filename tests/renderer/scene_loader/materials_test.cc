#include <gtest/gtest.h>

#include "renderer/scene_loader/scene_loader.h"
#include "tests/renderer/scene_loader/gltf_builder.h"
#include "tests/renderer/scene_loader/png.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(MaterialsTest, ATextureComesWithItsSamplerAndItsImageStaysEncoded) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  const std::string png = MakePng(7, 5);
  gltf.json["images"] = {{{"uri", "t.png"}}};
  gltf.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
  gltf.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
  gltf.json["materials"] = {
      {{"alphaMode", "MASK"},
       {"alphaCutoff", 0.25},
       {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"baseColorFactor", {0.5, 0.25, 1, 1}}}}}};
  gltf.primitive()["material"] = 0;
  const auto scene = LoadGltf(gltf.Text(), {{"a b.bin", &gltf.bytes}, {"t.png", &png}}, {});
  ASSERT_OK(scene);
  ASSERT_EQ(scene->materials.size(), 2u);
  const Material& material = scene->materials[scene->meshes[0].material];
  EXPECT_EQ(material.base_color, glm::vec4(0.5, 0.25, 1, 1));
  EXPECT_EQ(material.alpha_mode, AlphaMode::kMask);
  EXPECT_EQ(material.alpha_cutoff, 0.25f);
  ASSERT_EQ(material.base_color_texture.texture, 0);
  EXPECT_EQ(scene->textures[0].wrap_s, Wrap::kClampToEdge);
  EXPECT_EQ(scene->textures[0].wrap_t, Wrap::kMirroredRepeat);
  EXPECT_TRUE(scene->textures[0].magnifies_to_nearest);
  EXPECT_FALSE(scene->textures[0].minifies_to_nearest);
  EXPECT_EQ(scene->textures[0].mip_filter, MipFilter::kLinear);
  EXPECT_EQ(scene->images[0].bytes, png);
  EXPECT_EQ(scene->images[0].width, 7u);
  EXPECT_EQ(scene->images[0].height, 5u);
  EXPECT_THAT(scene->warnings, testing::IsEmpty());
}

TEST(MaterialsTest, EveryPartOfAMaterialIsRead) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  const std::string png = MakePng(2, 2);
  gltf.json["images"] = {{{"uri", "t.png"}}};
  for (int i = 0; i < 5; ++i) gltf.json["textures"].push_back({{"source", 0}});
  gltf.json["materials"] = {
      {{"alphaMode", "BLEND"},
       {"pbrMetallicRoughness",
        {{"metallicFactor", 0.25}, {"roughnessFactor", 0.75}, {"metallicRoughnessTexture", {{"index", 1}}}}},
       {"normalTexture", {{"index", 2}, {"scale", -2}, {"texCoord", 1}}},
       {"occlusionTexture", {{"index", 3}, {"strength", 0.5}}},
       {"emissiveFactor", {0.5, 0.25, 1}},
       {"emissiveTexture", {{"index", 4}, {"texCoord", 2}}}}};
  gltf.primitive()["material"] = 0;
  gltf.primitive()["attributes"]["TEXCOORD_1"] = gltf.Accessor<float>({0, 0, 1, 0, 0, 1}, "VEC2", 5126);
  gltf.primitive()["attributes"]["TANGENT"] = gltf.Accessor<float>({2, 0, 0, 1, 0, 3, 0, -1, 0, 0, 0, 1}, "VEC4", 5126);
  const auto scene = LoadGltf(gltf.Text(), {{"a b.bin", &gltf.bytes}, {"t.png", &png}}, {});
  ASSERT_OK(scene);
  const Material& material = scene->materials[0];
  EXPECT_EQ(material.metallic, 0.25f);
  EXPECT_EQ(material.roughness, 0.75f);
  EXPECT_EQ(material.metallic_roughness_texture.texture, 1);
  EXPECT_EQ(material.normal_texture.texture, 2);
  EXPECT_EQ(material.normal_texture.texcoord, 1);
  EXPECT_EQ(material.normal_scale, -2);
  EXPECT_EQ(material.occlusion_texture.texture, 3);
  EXPECT_EQ(material.occlusion_strength, 0.5f);
  EXPECT_EQ(material.emissive, glm::vec3(0.5, 0.25, 1));
  EXPECT_EQ(material.emissive_texture.texture, 4);
  EXPECT_EQ(material.emissive_texture.texcoord, 0);
  EXPECT_THAT(scene->texcoords1, ElementsAre(glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(0, 1)));
  EXPECT_THAT(scene->tangents, ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(0, 1, 0, -1), glm::vec4(0)));
  EXPECT_THAT(
      scene->warnings,
      ElementsAre(
          "/materials/0/alphaMode: BLEND hides alpha's share of the light, and is drawn where alpha is at least .5",
          "/materials/0/emissiveTexture: a third way to read texture coordinates; drawn with the "
          "material's first one"));
  EXPECT_EQ(material.alpha_cutoff, kBlendCutoff);
}

TEST(MaterialsTest, EveryFilterOfASamplerIsRead) {
  const auto load = [](int min_filter) {
    GltfBuilder gltf = GltfBuilder::Triangle();
    const std::string png = MakePng(2, 2);
    gltf.json["images"] = {{{"uri", "t.png"}}};
    gltf.json["samplers"] = {{{"minFilter", min_filter}, {"magFilter", 9729}}};
    gltf.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
    const auto scene = LoadGltf(gltf.Text(), {{"a b.bin", &gltf.bytes}, {"t.png", &png}}, {});
    EXPECT_OK(scene);
    EXPECT_FALSE(scene->textures[0].magnifies_to_nearest);
    return std::pair(scene->textures[0].minifies_to_nearest, scene->textures[0].mip_filter);
  };
  EXPECT_EQ(load(9728), std::pair(true, MipFilter::kNone));
  EXPECT_EQ(load(9729), std::pair(false, MipFilter::kNone));
  EXPECT_EQ(load(9984), std::pair(true, MipFilter::kNearest));
  EXPECT_EQ(load(9985), std::pair(false, MipFilter::kNearest));
  EXPECT_EQ(load(9986), std::pair(true, MipFilter::kLinear));
  EXPECT_EQ(load(9987), std::pair(false, MipFilter::kLinear));
}

TEST(MaterialsTest, WithoutAMaterialTheDefaultLastOneIsUsed) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["materials"] = {{{"name", "unused"}}};
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->meshes[0].material, 1u);
  EXPECT_EQ(scene->materials[1].base_color, glm::vec4(1));
}

TEST(MaterialsTest, ImagesThatCannotBeReadLeaveTheFactorAndAWarning) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  const std::string webp = "RIFF____WEBPVP8 ", large = MakePng(7, 5), good = MakePng(2, 2);
  gltf.json["images"] = {{{"uri", "0"}}, {{"uri", "1"}}, {{"uri", "2"}}};
  gltf.json["textures"] = {{{"source", 0}}, {{"source", 1}}, {{"name", "no source"}}, {{"source", 2}}};
  for (int i = 0; i < 4; ++i) {
    gltf.json["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
  }
  SceneLoadLimits limits;
  limits.max_texture_pixels = 34;
  const auto scene =
      LoadGltf(gltf.Text(), {{"a b.bin", &gltf.bytes}, {"0", &webp}, {"1", &large}, {"2", &good}}, limits);
  ASSERT_OK(scene);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(scene->materials[i].base_color_texture.texture, -1) << i;
  ASSERT_EQ(scene->materials[3].base_color_texture.texture, 0);
  ASSERT_EQ(scene->images.size(), 1u);
  EXPECT_EQ(scene->images[scene->textures[0].image].name, "/images/2");
  EXPECT_THAT(
      scene->warnings,
      ElementsAre(HasSubstr("/images/0: a WebP image, not a PNG or a JPEG"), HasSubstr("/images/1: 7 x 5 pixels"),
                  HasSubstr("/materials/0/pbrMetallicRoughness/baseColorTexture: has no image that can be read; "
                            "left out (here and in 2 more places)")));
}

TEST(WarningsTest, WhatIsLeftOutIsSaid) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["extensionsUsed"] = {"EXT_texture_webp"};
  gltf.json["nodes"][0]["visible"] = false;
  gltf.json["nodes"][0]["rotation"] = {0, 0, 0, 0.5};
  gltf.primitive()["targets"] = {{{"POSITION", 0}}};
  gltf.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
  gltf.json["meshes"][0]["primitives"].push_back({{"attributes", nlohmann::json::object()}});
  gltf.primitive()["indices"] = gltf.Accessor<uint8_t>({0, 1, 2, 0, 1}, "SCALAR", 5121);
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  for (const char* warning : {
           "/nodes/0/visible: is no property of glTF 2.0; ignored",
           "/extensionsUsed/0: \"EXT_texture_webp\" is not supported; the scene is drawn without it",
           "/meshes/0/primitives/0/indices: 5 indices; triangles take three each, what is left over is not drawn",
           "/meshes/0/primitives/1/mode: points and lines are not drawn",
           "/meshes/0/primitives/2/attributes: without POSITION nothing is drawn",
           "/nodes/0/rotation: no unit quaternion; made one",
       }) {
    EXPECT_THAT(scene->warnings, testing::Contains(warning));
  }
}

TEST(WarningsTest, AreFewHoweverManyTheCauses) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["skins"] = {{{"joints", {0}}}};
  for (int i = 0; i < 999; ++i) gltf.json["nodes"].push_back({{"skin", 0}});
  auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_THAT(scene->warnings,
              ElementsAre("/nodes/1/skin: without a mesh nothing is bent (here and in 998 more places)"));
  for (int i = 0; i < 999; ++i) gltf.json["extensionsUsed"].push_back("EXT_" + std::to_string(i));
  scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->warnings.size(), 65u);
  EXPECT_THAT(scene->warnings.back(), HasSubstr("more warnings"));
}

}  // namespace
}  // namespace halfshade
