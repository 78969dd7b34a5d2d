#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "client/glb_writer.h"
#include "client/obj_to_glb.h"
#include "renderer/scene_loader/scene_loader.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

GlbMesh Triangle() {
  GlbMesh mesh;
  mesh.name = "triangle";
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.indices = {0, 1, 2};
  return mesh;
}

TEST(WriteGlbTest, TheSameMeshesGiveTheSameBytes) {
  EXPECT_EQ(WriteGlb({Triangle(), Triangle()}), WriteGlb({Triangle(), Triangle()}));
  GlbMesh other = Triangle();
  other.positions[0].x = 0.5f;
  EXPECT_NE(WriteGlb({other}), WriteGlb({Triangle()}));
}

TEST(WriteGlbTest, ChunksAreAlignedAndTheLengthIsTheFiles) {
  for (size_t name = 0; name < 5; ++name) {
    GlbMesh mesh = Triangle();
    mesh.name = std::string(name, 'x');
    const std::string glb = WriteGlb({mesh});
    EXPECT_EQ(glb.size() % 4, 0u);
    uint32_t length = 0;
    std::memcpy(&length, glb.data() + 8, 4);
    EXPECT_EQ(length, glb.size());
  }
}

TEST(WriteGlbTest, AMeshWithoutTrianglesIsLeftOut) {
  GlbMesh empty;
  empty.name = "empty";
  const auto scene = LoadGltf(WriteGlb({empty, Triangle()}), {}, {});
  ASSERT_OK(scene);
  ASSERT_EQ(scene->nodes.size(), 1u);
  EXPECT_EQ(scene->nodes[0].name, "triangle");
}

class ObjTest : public testing::Test {
 protected:
  ObjTest() : folder_(fs::temp_directory_path() / ("halfshade_obj_test_" + std::to_string(getpid()))) {
    fs::create_directories(folder_ / "model");
  }
  ~ObjTest() override { fs::remove_all(folder_); }

  std::string Write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  absl::StatusOr<FlatScene> Load(const std::string& obj) {
    const auto glb = ObjToGlb(Write("model/m.obj", obj));
    if (!glb.ok()) return glb.status();
    return LoadGltf(*glb, {}, {});
  }

  fs::path folder_;
};

constexpr char kSquare[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST_F(ObjTest, PolygonsAreTriangulated) {
  const auto scene = Load(std::string(kSquare) + "f 1 2 3 4\n");
  ASSERT_OK(scene);
  ASSERT_EQ(scene->meshes.size(), 1u);
  EXPECT_EQ(scene->meshes[0].TriangleCount(), 2u);
  EXPECT_EQ(scene->positions.size(), 4u) << "shared corners stay shared";
  EXPECT_EQ(scene->normals, std::vector<glm::vec3>(4, {0, 0, 1})) << "made from the faces";
  EXPECT_TRUE(scene->materials[0].is_double_sided);
}

TEST_F(ObjTest, NegativeIndicesCountFromTheEnd) {
  const auto scene = Load(std::string(kSquare) + "f -4 -3 -2\n");
  ASSERT_OK(scene);
  EXPECT_EQ(scene->meshes[0].TriangleCount(), 1u);
}

TEST_F(ObjTest, CornersWithTheirOwnNormalsAndTexcoordsComeApart) {
  const auto scene =
      Load(std::string(kSquare) + "vt 0 0\nvt 1 0.25\nvn 0 0 2\nvn 0 0 -1\nf 1/1/1 2/2/1 3/1/1\nf 1/1/2 3/1/2 4/1/2\n");
  ASSERT_OK(scene);
  EXPECT_EQ(scene->positions.size(), 6u);
  EXPECT_EQ(scene->normals[0], glm::vec3(0, 0, 1)) << "made unit";
  EXPECT_EQ(scene->texcoords[1], glm::vec2(1, 0.75)) << "OBJ counts v from below";
}

TEST_F(ObjTest, MaterialsOfTheFolderGiveTheirColour) {
  Write("model/m.mtl", "newmtl red\nKd 1 0.25 0\n");
  const auto scene = Load("mtllib m.mtl\n" + std::string(kSquare) + "usemtl red\nf 1 2 3\nusemtl none\nf 1 3 4\n");
  ASSERT_OK(scene);
  ASSERT_EQ(scene->meshes.size(), 2u);
  std::vector<glm::vec4> colors;
  for (const Mesh& mesh : scene->meshes) colors.push_back(scene->materials[mesh.material].base_color);
  EXPECT_THAT(colors, testing::UnorderedElementsAre(glm::vec4(1, 0.25, 0, 1), glm::vec4(0.8f, 0.8f, 0.8f, 1)));
}

TEST_F(ObjTest, MaterialsOutsideTheFolderAreRefusedAndAbsentOnesAreGrey) {
  Write("secret.mtl", "newmtl red\nKd 1 0 0\n");
  fs::create_symlink(folder_ / "secret.mtl", folder_ / "model/link.mtl");
  const std::string rest = std::string(kSquare) + "usemtl red\nf 1 2 3\n";
  for (const char* name : {"../secret.mtl", "/etc/passwd", "link.mtl"}) {
    EXPECT_THAT(Load(std::string("mtllib ") + name + "\n" + rest),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("outside the OBJ's folder")))
        << name;
  }
  const auto grey = Load("mtllib absent.mtl\n" + rest);
  ASSERT_OK(grey);
  EXPECT_EQ(grey->materials[0].base_color, glm::vec4(0.8f, 0.8f, 0.8f, 1));
}

TEST_F(ObjTest, FacesThatNameWhatTheFileLacksAreRefused) {
  for (const char* face : {"f 1 2 9\n", "f 1//1 2//1 3//1\n", "f 1/5 2/5 3/5\n"}) {
    EXPECT_EQ(Load(kSquare + std::string(face)).status().code(), absl::StatusCode::kInvalidArgument) << face;
  }
}

TEST_F(ObjTest, WhatHasNoTrianglesIsRefusedByPath) {
  for (const char* text : {"", "v 0 0 0\n", "# nothing\n", "not an obj\n"}) {
    EXPECT_THAT(Load(text), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("m.obj: has no triangles")));
  }
  EXPECT_THAT(ObjToGlb(folder_ / "absent.obj"), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("absent.obj")));
  EXPECT_THAT(ObjToGlb(folder_), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("no regular file")));
}

}  // namespace
}  // namespace halfshade
