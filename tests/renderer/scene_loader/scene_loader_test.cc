#include "renderer/scene_loader/scene_loader.h"

#include <gtest/gtest.h>

#include "client/glb_writer.h"
#include "renderer/scene/pose.h"
#include "tests/renderer/scene_loader/gltf_builder.h"
#include "tests/renderer/scene_loader/png.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Corners of all triangles in object space.
std::vector<glm::dvec3> Corners(const FlatScene& scene) {
  std::vector<glm::dvec3> corners;
  for (const Mesh& mesh : scene.meshes) {
    for (uint32_t i = 0; i < mesh.index_count; ++i) {
      corners.push_back(mesh.origin +
                        glm::dvec3(scene.positions[mesh.first_vertex + scene.indices[mesh.first_index + i]]));
    }
  }
  return corners;
}

const std::vector<float> kSquare = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

TEST(LoadGltfTest, ATriangleStandsWhereItsNodePutsIt) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["nodes"][0]["translation"] = {0, 0, 5};
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_THAT(scene->warnings, testing::IsEmpty());
  EXPECT_THAT(Corners(*scene), ElementsAre(glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)));
  const auto pose = BuildPose(*scene, 0);
  ASSERT_OK(pose);
  EXPECT_EQ(pose->bounds_ws.min, glm::dvec3(0, 0, 5));
  EXPECT_EQ(pose->bounds_ws.max, glm::dvec3(1, 1, 5));
}

TEST(LoadGltfTest, TheSameGltfComesFromAFileADataUriAndAGlb) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  const auto from_file = gltf.Load();
  ASSERT_OK(from_file);
  gltf.json["buffers"] = {{{"byteLength", 39},
                           {"uri",
                            "data:application/octet-stream;base64,"
                            "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEC"}}};
  const auto from_uri = LoadGltf(gltf.Text(), {}, {});
  ASSERT_OK(from_uri);
  gltf.json["buffers"] = {{{"byteLength", 39}}};
  const auto from_glb = LoadGltf(MakeGlb(gltf.json.dump(), gltf.bytes), {}, {});
  ASSERT_OK(from_glb);
  for (const auto* scene : {&*from_uri, &*from_glb}) {
    EXPECT_EQ(scene->positions, from_file->positions);
    EXPECT_EQ(scene->indices, from_file->indices);
  }
}

TEST(LoadGltfTest, TheBinChunkIsBufferZeroAlone) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["buffers"] = {{{"byteLength", 39}}, {{"byteLength", 39}}};
  EXPECT_THAT(LoadGltf(MakeGlb(gltf.json.dump(), gltf.bytes), {}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, testing::StartsWith("/buffers/1: has no uri")));
}

TEST(LoadGltfTest, WhatWriteGlbWritesReadsBackAsTheSameScene) {
  GlbMesh mesh;
  mesh.name = "plate";
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {2, 0, 2}, {0, 0, 2}};
  mesh.normals.assign(4, {0, 1, 0});
  mesh.texcoords = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.indices = {0, 2, 1, 0, 3, 2};
  mesh.base_color = {0.1f, 0.2f, 0.3f, 1};
  mesh.is_double_sided = true;
  mesh.world_from_mesh[3] = glm::dvec4(10, 0, 0, 1);
  const auto scene = LoadGltf(WriteGlb({mesh}), {}, {});
  ASSERT_OK(scene);
  EXPECT_THAT(scene->positions,
              ElementsAre(glm::vec3(-1, 0, -1), glm::vec3(1, 0, -1), glm::vec3(1, 0, 1), glm::vec3(-1, 0, 1)));
  EXPECT_EQ(scene->meshes[0].origin, glm::dvec3(1, 0, 1));
  EXPECT_EQ(scene->normals, mesh.normals);
  EXPECT_EQ(scene->texcoords, mesh.texcoords);
  EXPECT_EQ(scene->indices, mesh.indices);
  ASSERT_EQ(scene->materials.size(), 2u) << "its own and the default";
  EXPECT_EQ(scene->materials[0].base_color, mesh.base_color);
  EXPECT_TRUE(scene->materials[0].is_double_sided);
  EXPECT_EQ(scene->nodes[0].name, "plate");
  EXPECT_EQ(BuildPose(*scene, 0)->bounds_ws.max, glm::dvec3(12, 0, 2));
}

TEST(LoadGltfTest, WriteGlbOfNothingIsASceneOfNothing) {
  const auto scene = LoadGltf(WriteGlb({}), {}, {});
  ASSERT_OK(scene);
  EXPECT_TRUE(scene->meshes.empty());
  EXPECT_THAT(scene->warnings, testing::IsEmpty());
}

TEST(GeometryTest, EveryTypeOfIndexNamesTheSameTriangles) {
  const auto load = [](auto type, int component) {
    GltfBuilder gltf;
    gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor(kSquare, "VEC3", 5126);
    gltf.primitive()["indices"] = gltf.Accessor<decltype(type)>({0, 1, 2, 0, 2, 3}, "SCALAR", component);
    const auto scene = gltf.Load();
    EXPECT_OK(scene);
    return scene.ok() ? scene->indices : std::vector<uint32_t>();
  };
  const std::vector<uint32_t> expected = {0, 1, 2, 0, 2, 3};
  EXPECT_EQ(load(uint8_t(), 5121), expected);
  EXPECT_EQ(load(uint16_t(), 5123), expected);
  EXPECT_EQ(load(uint32_t(), 5125), expected);
}

TEST(GeometryTest, EveryTypeOfTexcoordMeansTheSame) {
  const auto load = [](auto values, int component) {
    GltfBuilder gltf = GltfBuilder::Triangle();
    values.resize(values.size());
    const bool is_float = component == 5126;
    // Two components of a byte or short need padding to four bytes per element.
    const size_t accessor = gltf.Accessor(values, "VEC2", component, !is_float);
    gltf.json["accessors"][accessor]["count"] = 3;
    if (component == 5121) {
      gltf.json["bufferViews"].back()["byteStride"] = 4;
    }
    gltf.primitive()["attributes"]["TEXCOORD_0"] = accessor;
    const auto scene = gltf.Load();
    EXPECT_OK(scene);
    return scene.ok() ? scene->texcoords : std::vector<glm::vec2>();
  };
  const std::vector<glm::vec2> expected = {{0, 0}, {1, 0}, {0, 1}};
  EXPECT_EQ(load(std::vector<float>{0, 0, 1, 0, 0, 1}, 5126), expected);
  EXPECT_EQ(load(std::vector<uint8_t>{0, 0, 9, 9, 255, 0, 9, 9, 0, 255, 9, 9}, 5121), expected);
  EXPECT_EQ(load(std::vector<uint16_t>{0, 0, 65535, 0, 0, 65535}, 5123), expected);
}

TEST(GeometryTest, InterleavedVerticesReadWithTheirStride) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.View<float>({0, 0, 0, 0, 0, 2, 1, 0, 0, 0, 0, 2, 0, 1, 0, 0, 0, 2});
  gltf.json["bufferViews"][2]["byteStride"] = 24;
  const nlohmann::json accessor = {{"bufferView", 2}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}};
  gltf.json["accessors"][0] = accessor;
  gltf.json["accessors"].push_back(accessor);
  gltf.json["accessors"][2]["byteOffset"] = 12;
  gltf.primitive()["attributes"]["NORMAL"] = 2;
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_THAT(Corners(*scene), ElementsAre(glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)));
  EXPECT_EQ(scene->normals, std::vector<glm::vec3>(3, {0, 0, 1})) << "made unit";
}

TEST(GeometryTest, SparseValuesReplaceTheirElements) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", gltf.View<uint16_t>({1})}, {"componentType", 5123}}},
      {"values", {{"bufferView", gltf.View<float>({7, 0, 0})}}}};
  auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_THAT(Corners(*scene), ElementsAre(glm::dvec3(0), glm::dvec3(7, 0, 0), glm::dvec3(0, 1, 0)));
  gltf.json["accessors"][0].erase("bufferView");
  scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->degenerate_triangles_dropped, 1u) << "over zeros the triangle is a line";
}

TEST(GeometryTest, StripsAndFansKeepTheWinding) {
  const auto load = [](int mode, std::vector<uint8_t> indices) {
    GltfBuilder gltf;
    gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor(kSquare, "VEC3", 5126);
    gltf.primitive()["indices"] = gltf.Accessor(indices, "SCALAR", 5121);
    gltf.primitive()["mode"] = mode;
    const auto scene = gltf.Load();
    EXPECT_OK(scene);
    return scene.ok() ? scene->indices : std::vector<uint32_t>();
  };
  EXPECT_THAT(load(5, {0, 1, 3, 2}), ElementsAre(0, 1, 3, 1, 2, 3));
  EXPECT_THAT(load(6, {0, 1, 2, 3}), ElementsAre(1, 2, 0, 2, 3, 0));
  EXPECT_THAT(load(5, {0, 1}), ElementsAre());
}

TEST(GeometryTest, VerticesWithoutIndicesAreTakenInOrder) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.primitive().erase("indices");
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_THAT(scene->indices, ElementsAre(0, 1, 2));
}

TEST(GeometryTest, OnlyUsedVerticesAreKeptAndMeasured) {
  GltfBuilder gltf;
  std::vector<float> positions = {1e6f, 1e6f, 1e6f};
  positions.insert(positions.end(), kSquare.begin(), kSquare.end());
  gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor(positions, "VEC3", 5126);
  gltf.primitive()["indices"] = gltf.Accessor<uint8_t>({4, 1, 3}, "SCALAR", 5121);
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->positions.size(), 3u);
  EXPECT_THAT(scene->indices, ElementsAre(2, 0, 1));
  EXPECT_EQ(scene->meshes[0].origin, glm::dvec3(0.5, 0.5, 0));
  EXPECT_EQ(scene->meshes[0].bounds.max, glm::vec3(0.5, 0.5, 0));
}

TEST(GeometryTest, FarGeometryKeepsItsShapeAroundTheOrigin) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.primitive()["attributes"]["POSITION"] =
      gltf.Accessor<float>({1e7f, 0, 0, 1e7f + 1, 0, 0, 1e7f, 1, 0}, "VEC3", 5126);
  gltf.json["accessors"].back()["min"] = {5, 5, 5};
  gltf.json["accessors"].back()["max"] = {6, 6, 6};
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->meshes[0].origin, glm::dvec3(1e7 + 0.5, 0.5, 0)) << "measured, not what the file says";
  EXPECT_EQ(scene->positions[1], glm::vec3(0.5, -0.5, 0));
}

TEST(GeometryTest, TrianglesWithoutAreaAreDroppedAndCounted) {
  GltfBuilder gltf;
  gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor<float>({0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0}, "VEC3", 5126);
  gltf.primitive()["indices"] = gltf.Accessor<uint8_t>({0, 1, 2, 0, 1, 1, 0, 1, 3}, "SCALAR", 5121);
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->degenerate_triangles_dropped, 2u);
  EXPECT_EQ(scene->meshes[0].TriangleCount(), 1u);
  EXPECT_THAT(scene->warnings, ElementsAre("/meshes: triangles without an area are dropped: 2"));
}

TEST(GeometryTest, APrimitiveOfWhichNothingIsLeftMakesNoMesh) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.primitive()["indices"] = gltf.Accessor<uint8_t>({0, 1, 1}, "SCALAR", 5121);
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_TRUE(scene->meshes.empty());
  EXPECT_TRUE(BuildPose(*scene, 0)->bounds_ws.IsEmpty());
}

TEST(GeometryTest, ClustersCoverEveryTriangleOnce) {
  GltfBuilder gltf;
  std::vector<float> positions;
  for (int i = 0; i < 600; ++i) {
    const float x = float(i);
    positions.insert(positions.end(), {x, 0, 0, x + 1, 0, 0, x, 1, 0});
  }
  gltf.primitive()["attributes"]["POSITION"] = gltf.Accessor(positions, "VEC3", 5126);
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  ASSERT_EQ(scene->clusters.size(), 3u);
  uint32_t next = 0;
  for (const Cluster& cluster : scene->clusters) {
    EXPECT_EQ(cluster.first_triangle, next);
    EXPECT_LE(cluster.triangle_count, Cluster::kMaxTriangles);
    EXPECT_EQ(cluster.bounds.min.x + float(scene->meshes[0].origin.x), float(next));
    next += cluster.triangle_count;
    EXPECT_EQ(cluster.bounds.max.x + float(scene->meshes[0].origin.x), float(next));
  }
  EXPECT_EQ(next, 600u);
}

TEST(NodesTest, HierarchyAndInstancesMultiplyOut) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["nodes"] = {{{"mesh", 0}, {"translation", {1, 0, 0}}},
                        {{"children", {0, 2}}, {"scale", {2, 2, 2}}, {"rotation", {0, 0, 0.70710678, 0.70710678}}},
                        {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 3, 1}}}};
  gltf.json["scenes"][0]["nodes"] = {1};
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->meshes.size(), 1u) << "one mesh, two instances";
  const auto pose = BuildPose(*scene, 0);
  ASSERT_OK(pose);
  ASSERT_EQ(pose->instances.size(), 2u);
  // x -> y, y -> -x, times two.
  const glm::dvec3 corner(WorldFromNode(*scene, 0) * glm::dvec4(0, 1, 0, 1));
  EXPECT_NEAR(glm::distance(corner, glm::dvec3(-2, 2, 0)), 0, 1e-7);
  EXPECT_NEAR(pose->bounds_ws.max.z, 6, 1e-7);
  EXPECT_NEAR(pose->bounds_ws.min.x, -2, 1e-7);
}

TEST(NodesTest, AChainAsDeepAsItsNodesNeedsNoStack) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["nodes"] = nlohmann::json::array();
  constexpr int kDepth = 100000;
  for (int i = 0; i < kDepth; ++i) gltf.json["nodes"].push_back({{"children", {i + 1}}, {"translation", {0, 0, 1}}});
  gltf.json["nodes"].push_back({{"mesh", 0}});
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(BuildPose(*scene, 0)->bounds_ws.max.z, kDepth);
}

TEST(NodesTest, AFileWithoutScenesShowsItsRoots) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json.erase("scenes");
  gltf.json.erase("scene");
  gltf.json["nodes"].push_back({{"children", {0}}});
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  ASSERT_EQ(scene->scenes.size(), 1u);
  EXPECT_THAT(scene->scenes[0].roots, ElementsAre(1));
  EXPECT_THAT(scene->warnings, ElementsAre("/scenes: there is no scene; every root node is shown"));
}

TEST(NodesTest, CamerasComeWithTheirNodes) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["cameras"] = {
      {{"type", "perspective"}, {"name", "eye"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}},
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 2}, {"znear", 0}, {"zfar", 9}}}}};
  gltf.json["nodes"].push_back({{"camera", 1}});
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  ASSERT_EQ(scene->cameras.size(), 2u);
  EXPECT_EQ(scene->cameras[0].name, "eye");
  EXPECT_EQ(scene->cameras[0].fovy_rad, 0.5);
  EXPECT_EQ(scene->cameras[0].far_m, 0);
  EXPECT_TRUE(scene->cameras[1].is_orthographic);
  EXPECT_EQ(scene->cameras[1].ortho_height_m, 4);
  EXPECT_EQ(scene->cameras[1].far_m, 9);
  EXPECT_EQ(scene->nodes[0].camera, -1);
  EXPECT_EQ(scene->nodes[1].camera, 1);
}

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
  EXPECT_THAT(scene->warnings,
              ElementsAre("/materials/0/emissiveTexture/texCoord: only TEXCOORD_0 and TEXCOORD_1 are read; drawn with "
                          "TEXCOORD_0",
                          "/materials/0/alphaMode: BLEND is drawn, and occludes, as OPAQUE"));
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

TEST(GeometryTest, AttributesThatNoMaterialAsksForAreNotKept) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.primitive()["attributes"]["TEXCOORD_1"] = gltf.Accessor<float>({0, 0, 1, 0, 0, 1}, "VEC2", 5126);
  gltf.primitive()["attributes"]["TANGENT"] = gltf.Accessor<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, "VEC4", 5126);
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_TRUE(scene->texcoords1.empty());
  EXPECT_TRUE(scene->tangents.empty());
  EXPECT_TRUE(scene->colors.empty());
}

TEST(GeometryTest, EveryTypeOfVertexColourMeansTheSame) {
  const auto load = [](auto values, const char* type, int component, int stride) {
    GltfBuilder gltf = GltfBuilder::Triangle();
    const size_t accessor = gltf.Accessor(values, type, component, component != 5126);
    gltf.json["accessors"][accessor]["count"] = 3;
    if (stride > 0) gltf.json["bufferViews"].back()["byteStride"] = stride;
    gltf.primitive()["attributes"]["COLOR_0"] = accessor;
    const auto scene = gltf.Load();
    EXPECT_OK(scene);
    return scene.ok() ? scene->colors : std::vector<glm::vec4>();
  };
  const std::vector<glm::vec4> rgb = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}};
  std::vector<glm::vec4> rgba = rgb;
  for (glm::vec4& color : rgba) color.a = 0;
  EXPECT_EQ(load(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3", 5126, 0), rgb);
  EXPECT_EQ(load(std::vector<float>{2, 0, 0, -1, 1, 0, 0, 1, 1}, "VEC3", 5126, 0),
            (std::vector<glm::vec4>{{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 1, 1, 1}}))
      << "clamped to [0,1]";
  EXPECT_EQ(load(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, "VEC4", 5126, 0), rgba);
  EXPECT_EQ(load(std::vector<uint8_t>{255, 0, 0, 9, 0, 255, 0, 9, 0, 0, 255, 9}, "VEC3", 5121, 4), rgb);
  EXPECT_EQ(load(std::vector<uint8_t>{255, 0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0}, "VEC4", 5121, 0), rgba);
  EXPECT_EQ(load(std::vector<uint16_t>{65535, 0, 0, 9, 0, 65535, 0, 9, 0, 0, 65535, 9}, "VEC3", 5123, 8), rgb);
}

TEST(GeometryTest, MeshesWithoutAnAttributeFillItsArray) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  const auto plain = gltf.primitive();
  gltf.primitive()["attributes"]["COLOR_0"] = gltf.Accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3", 5126);
  const auto coloured = gltf.primitive();
  gltf.json["meshes"][0]["primitives"] = {plain, coloured, plain};
  const auto scene = gltf.Load();
  ASSERT_OK(scene);
  ASSERT_EQ(scene->colors.size(), 9u);
  EXPECT_EQ(scene->colors[0], glm::vec4(1));
  EXPECT_EQ(scene->colors[3], glm::vec4(1, 0, 0, 1));
  EXPECT_EQ(scene->colors[8], glm::vec4(1));
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
      ElementsAre(HasSubstr("/images/0: neither a PNG nor a JPEG"), HasSubstr("/images/1: 7 x 5 pixels"),
                  HasSubstr("/materials/0/pbrMetallicRoughness/baseColorTexture: has no image that can be read; "
                            "left out (here and in 2 more places)")));
}

TEST(WarningsTest, WhatIsLeftOutIsSaid) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  gltf.json["extensionsUsed"] = {"KHR_texture_transform"};
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
           "/extensionsUsed/0: \"KHR_texture_transform\" is not supported; the scene is drawn without it",
           "/meshes/0/primitives/0/indices: 5 indices; triangles take three each, what is left over is not drawn",
           "/meshes/0/primitives/0/targets: morph targets are not applied",
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
  EXPECT_THAT(scene->warnings, ElementsAre("/nodes/1/skin: skins are not applied (here and in 998 more places)"));
  for (int i = 0; i < 999; ++i) gltf.json["extensionsUsed"].push_back("EXT_" + std::to_string(i));
  scene = gltf.Load();
  ASSERT_OK(scene);
  EXPECT_EQ(scene->warnings.size(), 65u);
  EXPECT_THAT(scene->warnings.back(), HasSubstr("more warnings"));
}

TEST(ContainerTest, TruncatedGlbsAreRefusedAtEveryByte) {
  const GltfBuilder gltf = GltfBuilder::Triangle();
  const std::string glb = MakeGlb(gltf.Text(), gltf.bytes);
  const FileMap files = {{"a b.bin", &gltf.bytes}};
  ASSERT_OK(LoadGltf(glb, files, {}));
  for (size_t size = 0; size < glb.size(); ++size) {
    EXPECT_EQ(LoadGltf(glb.substr(0, size), files, {}).status().code(), absl::StatusCode::kInvalidArgument) << size;
  }
}

TEST(ContainerTest, BrokenHeadersAreRefusedByName) {
  const GltfBuilder gltf = GltfBuilder::Triangle();
  const FileMap files = {{"a b.bin", &gltf.bytes}};
  const auto broken = [&](size_t at, uint32_t value) {
    std::string glb = MakeGlb(gltf.Text(), gltf.bytes);
    std::memcpy(glb.data() + at, &value, 4);
    return std::string(LoadGltf(glb, files, {}).status().message());
  };
  EXPECT_THAT(broken(4, 1), testing::StartsWith("GLB: version 1"));
  EXPECT_THAT(broken(8, 0xffffffff), testing::StartsWith("GLB: length 4294967295"));
  EXPECT_THAT(broken(12, 0xfffffffc), testing::StartsWith("GLB: chunk 0: 4294967292 bytes"));
  EXPECT_THAT(broken(12, 2), testing::StartsWith("GLB: chunk 0: its length is not a multiple of 4"));
  EXPECT_THAT(broken(16, 0x004e4942), testing::StartsWith("GLB: chunk 0: the first chunk"));
}

}  // namespace
}  // namespace halfshade
