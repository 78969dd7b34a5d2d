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
