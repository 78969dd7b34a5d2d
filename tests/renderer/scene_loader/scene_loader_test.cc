#include "renderer/scene_loader/scene_loader.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "client/glb_writer.h"
#include "renderer/scene/pose.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// One triangle of floats at z = 0 in buffer 0, its corner numbers 0, 1, 2 as bytes behind it.
std::string TriangleBytes() {
  const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::string bytes(reinterpret_cast<const char*>(corners), sizeof(corners));
  return bytes + std::string("\0\1\2\0", 4);
}

constexpr char kTriangle[] = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
 "nodes":[{"mesh":0,"translation":[0,0,5]}],
 "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
 "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
              {"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"}],
 "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":4}],
 "buffers":[{"byteLength":40,"uri":"a%20b.bin"}]})";

absl::StatusOr<FlatScene> Load(const std::string& root, const SceneLoadLimits& limits = {}) {
  static const std::string& bytes = *new std::string(TriangleBytes());
  return LoadGltf(root, {{"a b.bin", &bytes}}, limits);
}

// kTriangle with one piece of text replaced.
std::string With(const std::string& from, const std::string& to) {
  std::string text = kTriangle;
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(LoadGltfTest, ATriangleFromAnExternalBufferStandsWhereItsNodePutsIt) {
  const auto scene = Load(kTriangle);
  ASSERT_OK(scene);
  ASSERT_EQ(scene->meshes.size(), 1u);
  EXPECT_EQ(scene->meshes[0].TriangleCount(), 1u);
  const auto pose = BuildPose(*scene, 0);
  ASSERT_OK(pose);
  EXPECT_EQ(pose->bounds_ws.min, glm::dvec3(0, 0, 5));
  EXPECT_EQ(pose->bounds_ws.max, glm::dvec3(1, 1, 5));
}

TEST(LoadGltfTest, WhatWriteGlbWritesReadsBackAsTheSameScene) {
  GlbMesh sphere = MakeSphere({1, 2, 3}, 0.5, 8);
  sphere.base_color = {0.1f, 0.2f, 0.3f, 1};
  sphere.world_from_mesh[3] = glm::dvec4(10, 0, 0, 1);
  const FlatScene expected = MakeFlatScene({sphere, MakePlate({0, 0, 0}, 2, 2)});
  const auto scene = LoadGltf(WriteGlb({sphere, MakePlate({0, 0, 0}, 2, 2)}), {}, {});
  ASSERT_OK(scene);
  EXPECT_EQ(scene->positions, expected.positions);
  EXPECT_EQ(scene->indices, expected.indices);
  EXPECT_EQ(scene->clusters.size(), expected.clusters.size());
  EXPECT_EQ(scene->materials[0].base_color, sphere.base_color);
  EXPECT_TRUE(scene->materials[1].is_double_sided);
  EXPECT_EQ(BuildPose(*scene, 0)->bounds_ws.max, BuildPose(expected, 0)->bounds_ws.max);
}

TEST(LoadGltfTest, DataUrisAreBuffers) {
  // 36 zero bytes but for two ones: (0,0,0), (1,0,0), (0,1,0).
  const auto scene = Load(R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
   "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
   "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
   "bufferViews":[{"buffer":0,"byteLength":36}],
   "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
  ASSERT_OK(scene);
  EXPECT_EQ(scene->meshes[0].TriangleCount(), 1u);
  EXPECT_EQ(scene->scenes.size(), 1u) << "a file without scenes shows its roots";
}

TEST(LoadGltfTest, DegenerateTrianglesAreDroppedAndCounted) {
  const std::string bytes = TriangleBytes().substr(0, 36) + std::string("\0\1\1\0", 4);
  const auto scene = LoadGltf(kTriangle, {{"a b.bin", &bytes}}, {});
  ASSERT_OK(scene);
  EXPECT_EQ(scene->degenerate_triangles_dropped, 1u);
  EXPECT_EQ(scene->meshes[0].TriangleCount(), 0u);
}

TEST(LoadGltfTest, AnIndexPastTheVerticesIsRefusedByAccessor) {
  const std::string bytes = TriangleBytes().substr(0, 36) + std::string("\0\1\3\0", 4);
  EXPECT_THAT(LoadGltf(kTriangle, {{"a b.bin", &bytes}}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("/meshes/0/primitives/0/indices: element 2 is 3 (/accessors/1); there are 3 vertices")));
}

TEST(LoadGltfTest, APositionThatIsNotFiniteIsRefusedByAccessor) {
  std::string bytes = TriangleBytes();
  const uint32_t nan = 0x7fc00000;
  std::memcpy(bytes.data() + 4, &nan, 4);
  EXPECT_THAT(LoadGltf(kTriangle, {{"a b.bin", &bytes}}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("element 0 is not finite (/accessors/0)")));
}

struct Fault {
  std::string name, from, to, message;
};

class FaultTest : public testing::TestWithParam<Fault> {};
INSTANTIATE_TEST_SUITE_P(
    Gltf, FaultTest,
    testing::ValuesIn(std::vector<Fault>{
        {"Version1", R"("version":"2.0")", R"("version":"1.0")", "/asset/version: "},
        {"RequiredExtension", R"("scene":0)", R"("extensionsRequired":["KHR_draco_mesh_compression"])", "/extensionsRequired/0: \"KHR_draco_mesh_compression\" is not supported"},
        {"AbsoluteUri", "a%20b.bin", "/etc/passwd", "/buffers/0/uri: \"/etc/passwd\" is not among the files"},
        {"UriOutside", "a%20b.bin", "../../etc/passwd", "/buffers/0/uri: \"../../etc/passwd\" is not among"},
        {"BadEscape", "a%20b.bin", "a%2", "/buffers/0/uri: "},
        {"BufferTooShort", R"("byteLength":40)", R"("byteLength":41)", "/buffers/0/byteLength: 41; there are 40 bytes"},
        {"ViewPastBuffer", R"("byteOffset":36,"byteLength":4)", R"("byteOffset":36,"byteLength":5)", "/bufferViews/1/byteLength: 5 from byteOffset 36"},
        {"ViewOffsetWraps", R"("byteOffset":36,)", R"("byteOffset":18446744073709551612,)", "/bufferViews/1/byteOffset: "},
        {"ViewOfNoBuffer", R"({"buffer":0,"byteLength":36})", R"({"buffer":1,"byteLength":36})", "/bufferViews/0/buffer: 1; the file has 1"},
        {"AccessorPastView", R"("count":3,"type":"VEC3")", R"("count":4,"type":"VEC3")", "/accessors/0/count: 4 elements pass the end"},
        {"AccessorCountHuge", R"("count":3,"type":"VEC3")", R"("count":4294967296,"type":"VEC3")", "/accessors/0/count: "},
        {"ComponentType", R"("componentType":5126)", R"("componentType":5124)", "/accessors/0/componentType: 5124; no such type"},
        {"PositionOfBytes", R"("componentType":5126,"count":3)", R"("componentType":5121,"count":3)", "/meshes/0/primitives/0/attributes/POSITION: "},
        {"IndicesOfFloats", R"("componentType":5121,"count":3)", R"("componentType":5126,"count":1)", "/meshes/0/primitives/0/indices: "},
        {"NoSuchAccessor", R"("POSITION":0)", R"("POSITION":7)", "/meshes/0/primitives/0/attributes/POSITION: 7; the file has 2"},
        {"NoSuchMesh", R"("mesh":0)", R"("mesh":1)", "/nodes/0/mesh: 1; the file has 1"},
        {"NoSuchNode", R"("nodes":[0])", R"("nodes":[3])", "/scenes/0/nodes/0: 3; the file has 1"},
        {"OwnAncestor", R"("mesh":0,)", R"("mesh":0,"children":[0],)", "/nodes/0: is its own ancestor"},
        {"SceneIndex", R"("scene":0)", R"("scene":1)", "/scene: 1; the file has 1"},
        {"TranslationText", "[0,0,5]", R"([0,0,"5"])", "/nodes/0/translation/2: must be a number"},
        {"MatrixAndTranslation", R"("mesh":0,)", R"("mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],)", "/nodes/0/matrix: "},
        {"NotJson", R"({"asset")", "{asset", "JSON: not well-formed"},
        {"MeshNoArray", R"("meshes":[{)", R"("meshes":{"0":[)", "JSON: not well-formed"}}),
    [](const auto& info) { return info.param.name; });

TEST_P(FaultTest, IsRefusedWithItsPointer) {
  const auto scene = Load(With(GetParam().from, GetParam().to));
  EXPECT_EQ(scene.status().code(), absl::StatusCode::kInvalidArgument) << scene.status();
  EXPECT_TRUE(std::string(scene.status().message()).starts_with(GetParam().message)) << scene.status();
}

TEST(ContainerTest, TruncatedGlbsAreRefusedAtEveryByte) {
  const std::string glb = WriteGlb({MakePlate({0, 0, 0}, 1, 1)});
  ASSERT_OK(LoadGltf(glb, {}, {}));
  for (size_t size = 0; size < glb.size(); ++size) {
    EXPECT_EQ(LoadGltf(glb.substr(0, size), {}, {}).status().code(), absl::StatusCode::kInvalidArgument) << size;
  }
}

TEST(LimitsTest, JsonDepthHoldsOnBothSides) {
  SceneLoadLimits limits;
  limits.max_json_depth = 6;
  EXPECT_OK(Load(kTriangle, limits));
  limits.max_json_depth = 4;
  EXPECT_THAT(Load(kTriangle, limits), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("nested deeper than 4")));
  EXPECT_EQ(Load(std::string(1 << 20, '[')).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(LimitsTest, JsonBytesTrianglesAndSceneBytesHoldOnBothSides) {
  SceneLoadLimits limits;
  limits.max_json_bytes = sizeof(kTriangle) - 1;
  EXPECT_OK(Load(kTriangle, limits));
  limits.max_json_bytes -= 1;
  EXPECT_THAT(Load(kTriangle, limits), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("JSON: ")));
  limits = {};
  limits.max_triangles = 1;
  EXPECT_OK(Load(kTriangle, limits));
  limits.max_triangles = 0;
  EXPECT_THAT(Load(kTriangle, limits), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("over 0 triangles")));
  limits = {};
  limits.max_scene_bytes = 39;
  EXPECT_EQ(Load(kTriangle, limits).status().code(), absl::StatusCode::kInvalidArgument);
}

// --- The folder that HALFSHADE_TEST_DATA names.

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// The files beside a glTF, by relative path: what a client could have uploaded with it.
std::map<std::string, std::string> Beside(const fs::path& root) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(root.parent_path())) {
    if (entry.is_regular_file() && entry.file_size() < (32u << 20) && entry.path().extension() != ".gltf" &&
        entry.path().extension() != ".glb") {
      files[fs::relative(entry.path(), root.parent_path())] = ReadFile(entry.path());
    }
  }
  return files;
}

absl::StatusOr<FlatScene> LoadFile(const fs::path& path) {
  static std::map<fs::path, std::map<std::string, std::string>>& cache =
      *new std::map<fs::path, std::map<std::string, std::string>>;
  const auto [files, is_new] = cache.try_emplace(path.parent_path());
  if (is_new) files->second = Beside(path);
  FileMap map;
  for (const auto& [uri, bytes] : files->second) map[uri] = &bytes;
  return LoadGltf(ReadFile(path), map, {});
}

TEST(RealDataTest, CoreScenesLoadAndTheRestIsRefusedByName) {
  const char* data = std::getenv("HALFSHADE_TEST_DATA");
  if (data == nullptr) GTEST_SKIP() << "HALFSHADE_TEST_DATA is not set";
  for (const char* core : {"spot/spot.glb", "cornell/cornell.glb", "garage/garage.gltf", "camp/camp.gltf",
                           "graveyard/graveyard.gltf", "nefertiti/nefertiti.glb", "flight_helmet/FlightHelmet.gltf",
                           "many_cubes/many-cubes.gltf", "trees_masked/trees_masked.glb", "fox/fox.glb"}) {
    const auto scene = LoadFile(fs::path(data) / "scenes" / core);
    EXPECT_OK(scene) << core;
    if (scene.ok()) EXPECT_FALSE(scene->indices.empty()) << core;
  }
  for (const char* extended : {"spot_draco/spot_draco.glb", "spot_meshopt/spot_meshopt.glb",
                               "spot_quantized/spot_quantized.glb"}) {
    EXPECT_THAT(LoadFile(fs::path(data) / "scenes" / extended),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("/extensionsRequired/0: ")))
        << extended;
  }
}

TEST(RealDataTest, BadFilesNeverCrashAndAreRefusedAsInvalid) {
  const char* data = std::getenv("HALFSHADE_TEST_DATA");
  if (data == nullptr) GTEST_SKIP() << "HALFSHADE_TEST_DATA is not set";
  const fs::path bad = fs::path(data) / "bad";
  std::ifstream manifest(bad / "manifest.tsv");
  std::string line;
  std::getline(manifest, line);
  int files = 0, accepted_wrongly = 0, refused_wrongly = 0, unnamed = 0;
  while (std::getline(manifest, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, '\t');) cells.push_back(cell);
    if (cells.size() < 4) continue;
    const fs::path path = bad / cells[0];
    if ((path.extension() != ".gltf" && path.extension() != ".glb") || !fs::exists(path)) continue;
    const auto scene = LoadFile(path);
    ++files;
    const std::string& expect = cells[3];
    if (!scene.ok()) {
      EXPECT_EQ(scene.status().code(), absl::StatusCode::kInvalidArgument) << cells[0] << " " << scene.status();
    }
    if (expect == "INVALID_ARGUMENT" && scene.ok()) {
      ++accepted_wrongly;
      std::printf("accepted: %s\n", line.c_str());
    }
    if (expect.starts_with("ACCEPT") && !scene.ok()) {
      ++refused_wrongly;
      std::printf("refused: %s: %s\n", cells[0].c_str(), std::string(scene.status().message()).c_str());
    }
    if (expect == "INVALID_ARGUMENT" && !scene.ok() && cells.size() > 4 && !cells[4].empty()) {
      bool is_named = false;
      std::istringstream names(cells[4]);
      for (std::string name; std::getline(names, name, '|');) {
        is_named = is_named || std::string(scene.status().message()).find(name) != std::string::npos;
      }
      unnamed += !is_named;
    }
  }
  std::printf("%d files: %d accepted that must be refused, %d refused that must be accepted, %d refused without the name\n",
              files, accepted_wrongly, refused_wrongly, unnamed);
  EXPECT_GT(files, 400);
}

}  // namespace
}  // namespace halfshade
