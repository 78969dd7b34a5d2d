// Sweeps over the folder that HALFSHADE_TEST_DATA names: scenes that must load, files that must be refused by name.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include "renderer/scene/pose.h"
#include "renderer/scene_loader/decode_image.h"
#include "renderer/scene_loader/scene_loader.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// The files beside a glTF, by relative path: what a client could have uploaded with it.
const std::map<std::string, std::string>& Beside(const fs::path& folder) {
  static auto& cache = *new std::map<fs::path, std::map<std::string, std::string>>;
  const auto [files, is_new] = cache.try_emplace(folder);
  if (!is_new) return files->second;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string extension = entry.path().extension();
    if (entry.is_regular_file() && entry.file_size() < (32u << 20) && extension != ".gltf" && extension != ".glb") {
      files->second[fs::relative(entry.path(), folder)] = ReadFile(entry.path());
    }
  }
  return files->second;
}

absl::StatusOr<FlatScene> LoadFile(const fs::path& path) {
  FileMap map;
  for (const auto& [uri, bytes] : Beside(path.parent_path())) map[uri] = &bytes;
  return LoadGltf(ReadFile(path), map, {});
}

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

// "a[0].b" -> "/a/0/b"; a JSON pointer stays.
std::string AsPointer(const std::string& name) {
  std::string pointer;
  for (const char c : name) {
    if (c == '[' || c == '.') pointer += '/';
    if (c != '[' && c != '.' && c != ']') pointer += c;
  }
  return pointer;
}

// Whether the text holds one of the alternatives "x|a[0].b".
bool Names(const std::string& text, const std::string& alternatives) {
  for (const std::string& name : Split(alternatives, '|')) {
    if (text.find(name) != std::string::npos || text.find(AsPointer(name)) != std::string::npos) return true;
  }
  return alternatives.empty();
}

// What every loaded scene promises, whatever the file was.
void ExpectValid(const FlatScene& scene, const std::string& file) {
  EXPECT_EQ(scene.normals.size(), scene.positions.size()) << file;
  EXPECT_EQ(scene.texcoords.size(), scene.positions.size()) << file;
  for (const size_t size : {scene.texcoords1.size(), scene.tangents.size(), scene.colors.size()}) {
    EXPECT_TRUE(size == 0 || size == scene.positions.size()) << file;
  }
  for (const glm::vec3& p : scene.positions) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z)) << file;
  for (const Mesh& mesh : scene.meshes) {
    ASSERT_LE(size_t(mesh.first_vertex) + mesh.vertex_count, scene.positions.size()) << file;
    ASSERT_LE(size_t(mesh.first_index) + mesh.index_count, scene.indices.size()) << file;
    ASSERT_LE(size_t(mesh.first_cluster) + mesh.cluster_count, scene.clusters.size()) << file;
    ASSERT_LT(mesh.material, scene.materials.size()) << file;
    for (uint32_t i = 0; i < mesh.index_count; ++i) {
      ASSERT_LT(scene.indices[mesh.first_index + i], mesh.vertex_count) << file;
    }
  }
  for (const Material& material : scene.materials) {
    for (const MaterialTexture* texture :
         {&material.base_color_texture, &material.metallic_roughness_texture, &material.normal_texture,
          &material.occlusion_texture, &material.emissive_texture}) {
      ASSERT_LT(texture->texture, int32_t(scene.textures.size())) << file;
    }
  }
  for (const Texture& texture : scene.textures) ASSERT_LT(texture.image, scene.images.size()) << file;
  for (uint32_t i = 0; i < scene.scenes.size(); ++i) {
    const auto pose = BuildPose(scene, i);
    ASSERT_OK(pose) << file;
    if (pose->bounds_ws.IsEmpty()) continue;
    const glm::dvec3 sum = pose->bounds_ws.min + pose->bounds_ws.max;
    ASSERT_TRUE(std::isfinite(sum.x + sum.y + sum.z)) << file;
  }
}

// The folder of real data, or nothing.
fs::path DataFolder() {
  const char* data = std::getenv("HALFSHADE_TEST_DATA");
  return data == nullptr ? "" : data;
}

struct Row {
  std::string file, expect, must_name;
  bool IsGltf() const { return file.ends_with(".gltf") || file.ends_with(".glb"); }
};

class BadFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    if (DataFolder().empty()) GTEST_SKIP() << "HALFSHADE_TEST_DATA is not set";
    folder_ = DataFolder() / "bad";
    std::ifstream manifest(folder_ / "manifest.tsv");
    std::string line;
    std::getline(manifest, line);
    while (std::getline(manifest, line)) {
      std::vector<std::string> cells = Split(line, '\t');
      cells.resize(6);
      if (fs::exists(folder_ / cells[0])) rows_.push_back({cells[0], cells[3], cells[4]});
    }
  }

  fs::path folder_;
  std::vector<Row> rows_;
};

// Files whose expectation we do not share.
const std::set<std::string>& AcceptedAgainstTheManifest() {
  static const auto& files = *new std::set<std::string>{
      // Contents of optional extensions, which are ignored with a warning: they cannot make the picture wrong.
      "validator/ext/KHR_materials_variants/data/primitive/unresolved_references.gltf",
      // An empty array of meshes: exporters write them, the picture is right, and a warning says so.
      "sharpgltf/SpecialCases/Invalid_EmptyArray.gltf",
      // A good JPEG whose name ends in .png: the bytes tell.
      "made/img_jpeg_as_png.png",
  };
  return files;
}

TEST_F(BadFilesTest, EveryGltfIsValidWhenLoadedAndRefusedByNameWhenNot) {
  int count = 0, unnamed_either = 0;
  for (const Row& row : rows_) {
    if (!row.IsGltf()) continue;
    ++count;
    const auto scene = LoadFile(folder_ / row.file);
    const std::string said(scene.status().message());
    if (scene.ok()) {
      ExpectValid(*scene, row.file);
      const bool may_load = row.expect.starts_with("ACCEPT") || row.expect == "EITHER";
      EXPECT_TRUE(may_load || AcceptedAgainstTheManifest().contains(row.file)) << row.file << " loads";
      std::string warnings;
      for (const std::string& warning : scene->warnings) warnings += warning + "; ";
      unnamed_either += row.expect == "EITHER" && !Names(warnings, row.must_name);
    } else {
      EXPECT_EQ(scene.status().code(), absl::StatusCode::kInvalidArgument) << row.file << ": " << said;
      EXPECT_FALSE(row.expect.starts_with("ACCEPT") && row.expect.find('|') == std::string::npos)
          << row.file << ": " << said;
      if (row.expect != "EITHER") {
        EXPECT_TRUE(Names(said, row.must_name)) << row.file << " must name " << row.must_name << ": " << said;
      }
    }
  }
  EXPECT_GT(count, 500);
  RecordProperty("files", count);
  RecordProperty("either_loaded_without_naming", unnamed_either);
}

TEST_F(BadFilesTest, EveryImageDecodesOrIsInvalidArgument) {
  int count = 0;
  for (const Row& row : rows_) {
    if (row.IsGltf()) continue;
    ++count;
    const auto image = DecodeImage({row.file, ReadFile(folder_ / row.file), 0, 0}, 64u << 20);
    if (image.ok()) {
      EXPECT_EQ(image->texels.size(), size_t(image->width) * size_t(image->height) * 4) << row.file;
      EXPECT_TRUE(!row.expect.starts_with("INVALID") || AcceptedAgainstTheManifest().contains(row.file)) << row.file;
    } else {
      EXPECT_EQ(image.status().code(), absl::StatusCode::kInvalidArgument) << row.file;
      EXPECT_NE(row.expect, "ACCEPT") << row.file << ": " << image.status();
    }
  }
  EXPECT_GT(count, 100);
}

TEST(RealScenesTest, EveryOneLoadsWithItsTriangles) {
  if (DataFolder().empty()) GTEST_SKIP() << "HALFSHADE_TEST_DATA is not set";
  std::ifstream manifest(DataFolder() / "scenes/manifest.tsv");
  std::string line;
  std::getline(manifest, line);
  int loaded = 0;
  while (std::getline(manifest, line)) {
    const std::vector<std::string> cells = Split(line, '\t');
    const std::string& file = cells.at(1);
    const auto scene = LoadFile(DataFolder() / "scenes" / file);
    ASSERT_OK(scene) << file;
    ++loaded;
    ExpectValid(*scene, file);
    const auto pose = BuildPose(*scene, scene->default_scene);
    ASSERT_OK(pose) << file;
    uint64_t triangles = 0;
    for (const Instance& instance : pose->instances) triangles += scene->meshes[instance.mesh].TriangleCount();
    const uint64_t stated = std::stoull(cells.at(6));
    EXPECT_LE(triangles, stated) << file;
    EXPECT_TRUE(triangles == stated || scene->degenerate_triangles_dropped > 0) << file;
  }
  EXPECT_GE(loaded, 43);
}

}  // namespace
}  // namespace halfshade
