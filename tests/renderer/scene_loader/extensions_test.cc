// Extensions that are read, skins, targets and animations, from files to the flat scene.
#include <gtest/gtest.h>

#include "renderer/scene/pose.h"
#include "renderer/scene_loader/scene_loader.h"
#include "renderer/scene_loader/validate_gltf.h"
#include "tests/renderer/scene_loader/gltf_builder.h"
#include "tests/renderer/scene_loader/png.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(QuantizationTest, IntegersAreThemselvesOrNormalized) {
  for (const bool is_normalized : {false, true}) {
    GltfBuilder gltf = GltfBuilder::Triangle();
    gltf.json["extensionsUsed"] = gltf.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    // Padded to four components, as vertices must be.
    const size_t view = gltf.View<int16_t>({-32768, 0, 0, 0, 32767, 0, 0, 0, 0, 16384, 0, 0});
    gltf.json["bufferViews"][view]["byteStride"] = 8;
    gltf.json["accessors"].push_back(
        {{"bufferView", view}, {"componentType", 5122}, {"count", 3}, {"type", "VEC3"}, {"normalized", is_normalized}});
    gltf.primitive()["attributes"]["POSITION"] = 2;
    const auto scene = gltf.Load();
    ASSERT_OK(scene);
    const std::vector<glm::dvec3> corners = Corners(*scene);
    EXPECT_NEAR(corners[0].x, is_normalized ? -1 : -32768, 1e-6) << "the least integer is -1 too";
    EXPECT_NEAR(corners[1].x, is_normalized ? 1 : 32767, 1e-6);
    EXPECT_NEAR(corners[2].y, is_normalized ? 16384 / 32767.0 : 16384, 1e-6);
  }
}

TEST(TextureTransformTest, IsFoldedIntoTheCoordinatesOfItsSet) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  const std::string png = MakePng(2, 2);
  gltf.json["extensionsRequired"] = {"KHR_texture_transform"};
  gltf.json["images"] = {{{"uri", "t.png"}}};
  gltf.json["textures"] = {{{"source", 0}}};
  gltf.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                             {"emissiveTexture", {{"index", 0}, {"texCoord", 2}}}}};
  gltf.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {
      {"offset", {0.5, 0.25}}, {"scale", {2, 3}}, {"texCoord", 1}};
  gltf.primitive()["material"] = 0;
  gltf.primitive()["attributes"]["TEXCOORD_1"] = gltf.Accessor<float>({0, 0, 1, 0, 0, 1}, "VEC2", 5126);
  gltf.primitive()["attributes"]["TEXCOORD_2"] = gltf.Accessor<float>({9, 9, 8, 8, 7, 7}, "VEC2", 5126);
  const auto scene = LoadGltf(gltf.Text(), {{"a b.bin", &gltf.bytes}, {"t.png", &png}}, {});
  ASSERT_OK(scene);
  EXPECT_EQ(scene->materials[0].base_color_texture.texcoord, 0);
  EXPECT_EQ(scene->materials[0].emissive_texture.texcoord, 1);
  EXPECT_THAT(scene->texcoords, ElementsAre(glm::vec2(0.5, 0.25), glm::vec2(2.5, 0.25), glm::vec2(0.5, 3.25)));
  EXPECT_THAT(scene->texcoords1, ElementsAre(glm::vec2(9, 9), glm::vec2(8, 8), glm::vec2(7, 7)));
}

TEST(UnlitTest, GivesOffItsColourAndReflectsNothing) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 1, 0.75}}}}}};
  gltf.json["materials"][0]["extensions"]["KHR_materials_unlit"] = nlohmann::json::object();
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->materials[0].emissive, glm::vec3(0.5, 0.25, 1));
  EXPECT_EQ(scene->materials[0].base_color, glm::vec4(0, 0, 0, 0.75));
  EXPECT_EQ(scene->materials[0].metallic, 1) << "f0 is the base colour, black";
}

TEST(EmissiveStrengthTest, MultipliesTheFactor) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["materials"] = {{{"emissiveFactor", {1, 0.5, 0}}}};
  gltf.json["materials"][0]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 100;
  EXPECT_EQ(gltf.Load()->materials[0].emissive, glm::vec3(100, 50, 0));
}

TEST(BasisuTest, TheOtherImageIsDrawnOrAWarningNamesTheExtension) {
  for (const bool has_fallback : {true, false}) {
    GltfBuilder gltf = GltfBuilder::Triangle();
    const std::string png = MakePng(2, 2), ktx = "\xabKTX 20\xbb\r\n\x1a\n";
    gltf.json["extensionsRequired"] = {"KHR_texture_basisu"};
    gltf.json["images"] = {{{"uri", "t.png"}}, {{"uri", "t.ktx2"}}};
    gltf.json["textures"] = {nlohmann::json::object()};
    gltf.json["textures"][0]["extensions"]["KHR_texture_basisu"]["source"] = 1;
    if (has_fallback) gltf.json["textures"][0]["source"] = 0;
    gltf.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    const auto scene = LoadGltf(gltf.Text(), {{"a b.bin", &gltf.bytes}, {"t.png", &png}, {"t.ktx2", &ktx}}, {});
    ASSERT_OK(scene);
    EXPECT_EQ(scene->materials[0].base_color_texture.texture, has_fallback ? 0 : -1);
    EXPECT_THAT(scene->warnings, testing::Contains(HasSubstr("/images/1: a KTX2 image")));
    EXPECT_THAT(scene->warnings,
                testing::Contains(HasSubstr(has_fallback ? "KHR_texture_basisu: is not read; the texture's other image"
                                                         : "KHR_texture_basisu: is not read, and there is no other")));
  }
}

GltfBuilder Instanced(size_t count) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["accessors"].push_back({{"componentType", 5126}, {"count", count}, {"type", "VEC3"}});  // zeros
  gltf.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = 2;
  return gltf;
}

TEST(InstancingTest, AMillionInstancesAreAMillionPlacesOfOneMesh) {
  const auto scene = Instanced(1'000'000).Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->meshes.size(), 1u);
  EXPECT_EQ(scene->positions.size(), 3u);
  EXPECT_LT(scene->SizeBytes(), 1'000'000 * sizeof(InstancePlace) + 10'000);
  EXPECT_EQ(BuildPose(*scene, 0)->instances.size(), 1'000'000u);
}

TEST(InstancingTest, TheLimitHoldsOnBothSides) {
  EXPECT_OK(Instanced(kMaxElements).Load());
  EXPECT_THAT(Instanced(kMaxElements + 1).Load(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("EXT_mesh_gpu_instancing/attributes/TRANSLATION: /accessors/2 has 1048577 instances; "
                                 "at most 1048576")));
}

TEST(SkinTest, EveryNodeBendsACopyOfItsOwn) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.primitive()["attributes"]["JOINTS_0"] = gltf.Accessor(std::vector<uint8_t>(12, 0), "VEC4", 5121);
  gltf.primitive()["attributes"]["WEIGHTS_0"] =
      gltf.Accessor<uint8_t>({255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0}, "VEC4", 5121, true);
  gltf.json["skins"] = {{{"joints", {3}}}, {{"joints", {4}}}};
  gltf.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {50, 0, 0}}},
                        {{"mesh", 0}, {"skin", 1}},
                        {{"mesh", 0}},
                        {{"translation", {0, 0, 3}}},
                        {{"scale", {4, 4, 4}}}};
  gltf.json["scenes"][0]["nodes"] = {0, 1, 2, 3, 4};
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->meshes.size(), 3u);
  ASSERT_EQ(scene->deformed.size(), 2u);
  const Pose pose = *BuildPose(*scene, 0);
  ASSERT_EQ(pose.instances.size(), 3u);
  const auto corner = [&](int i) {
    const Mesh& mesh = scene->meshes[pose.instances[i].mesh];
    return glm::vec3(pose.instances[i].world_from_mesh * glm::dvec4(scene->positions[mesh.first_vertex + 1], 1));
  };
  EXPECT_EQ(corner(0), glm::vec3(1, 0, 3)) << "the joint says where, not the node";
  EXPECT_EQ(corner(1), glm::vec3(4, 0, 0));
  EXPECT_EQ(corner(2), glm::vec3(1, 0, 0));
}

// Every vertex by eight joints at an eighth each, of which the last stands 8 m up; both joints were bound where they
// were 3 m along x.
TEST(SkinTest, TwoSetsOfJointsAndTheirInverseBindMatricesCount) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.primitive()["attributes"]["JOINTS_0"] = gltf.Accessor(std::vector<uint16_t>(12, 0), "VEC4", 5123);
  gltf.primitive()["attributes"]["JOINTS_1"] =
      gltf.Accessor<uint8_t>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC4", 5121);
  for (const char* weights : {"WEIGHTS_0", "WEIGHTS_1"}) {
    gltf.primitive()["attributes"][weights] = gltf.Accessor(std::vector<float>(12, 0.125f), "VEC4", 5126);
  }
  std::vector<float> matrices;
  for (int joint = 0; joint < 2; ++joint) {
    for (const float value : {1.f, 0.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 0.f, 1.f, 0.f, -3.f, 0.f, 0.f, 1.f})
      matrices.push_back(value);
  }
  gltf.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", gltf.Accessor(matrices, "MAT4", 5126)}}};
  gltf.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}, {{"translation", {3, 0, 0}}}, {{"translation", {3, 8, 0}}}};
  gltf.json["scenes"][0]["nodes"] = {0, 1, 2};
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_THAT(Corners(*scene), ElementsAre(glm::dvec3(0, 1, 0), glm::dvec3(1, 1, 0), glm::dvec3(0, 2, 0)));
}

TEST(MorphTest, ATargetMayBeSparseOverNothingAndOfNormalizedShorts) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["extensionsUsed"] = gltf.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const size_t where = gltf.View<uint8_t>({2}), what = gltf.View<int16_t>({0, 0, -32767, 0});
  gltf.json["bufferViews"][what]["byteLength"] = 6;
  gltf.json["accessors"].push_back({{"componentType", 5122},
                                    {"count", 3},
                                    {"type", "VEC3"},
                                    {"normalized", true},
                                    {"sparse",
                                     {{"count", 1},
                                      {"indices", {{"bufferView", where}, {"componentType", 5121}}},
                                      {"values", {{"bufferView", what}}}}}});
  gltf.primitive()["targets"] = {{{"POSITION", 2}}};
  gltf.json["meshes"][0]["weights"] = {2};
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_THAT(Corners(*scene), ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, -2)));
}

TEST(MorphTest, TheWeightsOfTheNodeComeBeforeTheMeshs) {
  for (const bool has_own : {false, true}) {
    GltfBuilder gltf = GltfBuilder::Triangle();
    gltf.primitive()["targets"] = {{{"POSITION", gltf.Accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 5126)}}};
    gltf.json["meshes"][0]["weights"] = {2};
    if (has_own) gltf.json["nodes"][0]["weights"] = {3};
    const auto scene = gltf.Load();
    ASSERT_OK(scene);
    EXPECT_EQ(Corners(*scene)[0].z, has_own ? 3 : 2);
  }
}

// Lines are not drawn, so no vertex pays for their targets; nodes have their weights all the same.
TEST(MorphTest, WeightsAreBoundedWhereNoVertexIs) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["meshes"].push_back(gltf.json["meshes"][0]);
  nlohmann::json& lines = gltf.json["meshes"][1]["primitives"][0];
  lines["mode"] = 1;
  for (int i = 0; i < 1000; ++i) lines["targets"].push_back({{"POSITION", 0}});
  for (int i = 0; i < 10; ++i) gltf.json["nodes"].push_back({{"mesh", 1}});
  SceneLoadLimits limits;
  limits.max_scene_bytes = 60'000;
  EXPECT_OK(gltf.Load(limits));
  limits.max_scene_bytes = 39'999;
  EXPECT_THAT(gltf.Load(limits),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("/nodes/10: weights of morph targets take over 39999 bytes, the limit")));
}

GltfBuilder Moving(const std::vector<float>& times, const std::vector<float>& values) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  const size_t input = gltf.Accessor(times, "SCALAR", 5126), output = gltf.Accessor(values, "VEC3", 5126);
  gltf.json["animations"] = {{{"name", "go"},
                              {"samplers", {{{"input", input}, {"output", output}}}},
                              {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
  return gltf;
}

TEST(AnimationTest, ChannelsComeWithTheirKeys) {
  const auto scene = Moving({0, 2}, {0, 0, 0, 4, 0, 0}).Load();
  ASSERT_OK(scene);
  ASSERT_EQ(scene->animations.size(), 1u);
  EXPECT_EQ(scene->animations[0].name, "go");
  EXPECT_EQ(scene->animations[0].duration_s, 2);
  ASSERT_EQ(scene->channels.size(), 1u);
  EXPECT_EQ(scene->channels[0].interpolation, Interpolation::kLinear);
  EXPECT_THAT(scene->animation_values, ElementsAre(0, 0, 0, 4, 0, 0));
  ASSERT_EQ(scene->rests.size(), 1u);
}

TEST(AnimationTest, RotationsMayBeNormalizedIntegers) {
  for (const bool is_byte : {true, false}) {
    GltfBuilder gltf = GltfBuilder::Triangle();
    const size_t times = gltf.Accessor<float>({0}, "SCALAR", 5126);
    const size_t turn = is_byte ? gltf.Accessor<int8_t>({0, 0, -128, 0}, "VEC4", 5120, true)
                                : gltf.Accessor<int16_t>({0, 0, -32767, 0}, "VEC4", 5122, true);
    gltf.json["animations"] = {{{"samplers", {{{"input", times}, {"output", turn}, {"interpolation", "STEP"}}}},
                                {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}}}}}};
    const auto scene = gltf.Load();
    ASSERT_OK(scene);
    EXPECT_THAT(scene->animation_values, ElementsAre(0, 0, -1, 0));
    EXPECT_EQ(scene->channels.at(0).interpolation, Interpolation::kStep);
  }
}

TEST(AnimationTest, AChannelThatCannotBePlayedIsLeftOutAndSaidSo) {
  const std::pair<GltfBuilder, std::string> cases[] = {
      {Moving({1, 0}, {0, 0, 0, 4, 0, 0}), "its times do not increase"},
      {Moving({0, 1}, {0, 0, 0}), "3 values where 6 are needed"},
      {Moving({0, 1}, {0, 0, 0, 1.1e15f, 0, 0}), "not finite, or over 1e15"}};
  for (const auto& [gltf, warning] : cases) {
    const auto scene = gltf.Load();
    ASSERT_OK(scene);
    EXPECT_TRUE(scene->channels.empty());
    EXPECT_THAT(scene->warnings, ElementsAre(HasSubstr("/animations/0/channels/0: ")));
    EXPECT_THAT(scene->warnings[0], HasSubstr(warning));
  }
}

TEST(SuggestedLightsTest, AnEmittingRectangleIsOneAndALightOfTheFileToo) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor<float>({0, 0, 0, 2, 0, 0, 2, 0, 4, 0, 0, 4}, "VEC3", 5126);
  gltf.primitive()["indices"] = gltf.Accessor<uint8_t>({1, 2, 0, 3, 0, 2}, "SCALAR", 5121);
  gltf.json["materials"] = {{{"emissiveFactor", {1, 1, 1}}}};
  gltf.primitive()["material"] = 0;
  gltf.json["nodes"][0]["translation"] = {0, 10, 0};
  gltf.json["nodes"].push_back({{"translation", {0, 3, 0}}});
  gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 5}}};
  gltf.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  ASSERT_EQ(scene->warnings.size(), 2u);
  EXPECT_THAT(scene->warnings[0], HasSubstr("/nodes/1/extensions/KHR_lights_punctual: lights nothing by itself"));
  EXPECT_THAT(scene->warnings[0], HasSubstr(R"("center":{"x":0.0,"y":3.0,"z":0.0})"));
  EXPECT_THAT(scene->warnings[0], HasSubstr(R"("intensity":{"b":5.0,"g":5.0,"r":5.0})"));
  EXPECT_THAT(scene->warnings[1], HasSubstr("/nodes/0: shines"));
  EXPECT_THAT(scene->warnings[1], HasSubstr(R"("center":{"x":1.0,"y":10.0,"z":2.0})"));
  // Corners 1, 2, 0 turn from +z to -x about -y.
  EXPECT_THAT(scene->warnings[1], HasSubstr(R"("direction":{"x":0.0,"y":-1.0,"z":0.0})"));
}

}  // namespace
}  // namespace halfshade
