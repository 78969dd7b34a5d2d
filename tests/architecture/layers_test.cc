// Holds the sources to the plan of the house: what a room may include, that every test is built, how rooms are named.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

// Every path below is a prefix: a folder, or the beginning of a file's name. A file belongs to the longest one that
// fits.
struct Room {
  std::string path;
  Strings may_include;  // of the project's headers, beside the file's own folder and kVocabulary
};

// What the whole renderer, server and client speak.
const Strings kVocabulary = {"renderer/status.h", "renderer/request.h", "renderer/method_options.h",
                             "renderer/report.h", "renderer/cache_key.h"};

// In the order of design: nothing flows back up. Tests may include anything.
const std::vector<Room> kRooms = {
    {"renderer/math/", {}},
    {"renderer/image/", {}},
    {"renderer/gl/", {}},
    {"renderer/scene/", {"renderer/math/"}},
    {"renderer/scene/scene_on_context", {"renderer/gl/", "renderer/renderer.h"}},  // ImageDecoder
    {"renderer/scene/ray_", {"renderer/renderer.h"}},                              // ImageDecoder
    {"renderer/scene_loader/", {"renderer/scene/deform.h", "renderer/scene/flat_scene.h", "renderer/scene/pose.h"}},
    {"renderer/scene_loader/decode_image", {"renderer/scene/", "renderer/renderer.h"}},  // Rgba8Image
    {"renderer/scene_loader/fence/", {"renderer/renderer.h", "renderer/scene/flat_form.h", "renderer/scene_loader/"}},
    {"renderer/plan/",
     {"renderer/light/kept_meshes.h", "renderer/math/", "renderer/scene/flat_scene.h", "renderer/scene/pose.h"}},
    {"renderer/light/", {"renderer/gl/", "renderer/image/", "renderer/math/", "renderer/scene/"}},
    // A method's room has the door, and never another method's room.
    {"renderer/shadow/",
     {"renderer/gl/", "renderer/image/", "renderer/light/", "renderer/math/", "renderer/passes.h", "renderer/scene/",
      "renderer/shadow/shadow_method.h"}},
    // The one file that knows every method.
    {"renderer/shadow/registry.cc", {"renderer/renderer.h", "renderer/shadow/"}},
    {"renderer/shade/",
     {"renderer/gl/", "renderer/image/", "renderer/light/", "renderer/math/", "renderer/plan/", "renderer/scene/",
      "renderer/shade/ltc/ltc_table.h"}},
    {"renderer/shade/ltc/", {}},
    // The story walks through all rooms but the methods' own and the loader's.
    {"renderer/frame.",
     {"renderer/light/", "renderer/math/", "renderer/plan/", "renderer/scene/", "renderer/shade/",
      "renderer/shadow/shadow_method.h", "renderer/shadow/finish_visibility.h"}},
    {"renderer/seen_view.", {"renderer/light/", "renderer/shade/"}},
    {"renderer/light_view.", {"renderer/light/", "renderer/plan/", "renderer/shade/"}},
    {"renderer/soft_shadow_map.", {"renderer/image/", "renderer/plan/", "renderer/shadow/finish_visibility.h"}},
    {"renderer/renderer.",
     {"renderer/gl/", "renderer/image/", "renderer/light/", "renderer/math/", "renderer/plan/", "renderer/scene/",
      "renderer/shade/", "renderer/shadow/shadow_method.h", "renderer/shadow/finish_visibility.h"}},
    {"renderer/budget.", {}},
    {"renderer/calibrate.", {"renderer/scene/flat_scene.h"}},
    {"renderer/certify.", {"renderer/image/image.h", "renderer/light/", "renderer/scene/ray_scene.h"}},
    {"renderer/light_layers.", {"renderer/shadow/shadow_method.h", "renderer/shadow/finish_visibility.h"}},
    {"renderer/passes.", {"renderer/gl/"}},
    {"renderer/prepare_light.",
     {"renderer/gl/", "renderer/light/", "renderer/plan/", "renderer/scene/", "renderer/shadow/shadow_method.h"}},
    {"renderer/query.", {"renderer/light/", "renderer/shadow/shadow_method.h", "renderer/shadow/finish_visibility.h"}},
    {"renderer/warm_up.", {"renderer/scene/flat_scene.h"}},
    {"renderer/cache_key.h", {}},
    {"renderer/method_options.h", {}},
    {"renderer/request.h", {}},
    {"renderer/report.h", {}},
    {"renderer/status.h", {}},
    {"server/",
     {"halfshade/v1/", "renderer/calibrate.h", "renderer/gl/context.h", "renderer/image/", "renderer/math/",
      "renderer/plan/", "renderer/renderer.h", "renderer/scene/", "renderer/scene_loader/"}},
    {"client/", {"halfshade/v1/", "server/digest.h", "server/scene_name.h"}},
    {"client/output_file.h", {"server/file_operations.h"}},
    {"client/batch/",
     {"client/", "halfshade/v1/", "server/digest.h", "server/file_operations.h", "server/scene_name.h"}},
    {"client/batch/item_geometry", {"halfshade/v1/", "server/validate_field.h"}},  // what the server makes of it
    {"client/commands_batch.cc", {"halfshade/v1/", "client/batch/", "server/scene_name.h"}},
    {"client/bench/",
     {"client/", "halfshade/v1/", "renderer/image/", "server/digest.h", "server/encode.h", "server/scene_name.h",
      "tests/support/scene_makers.h"}},
    {"client/commands_bench.cc", {"halfshade/v1/", "client/bench/", "renderer/image/"}},
    {"client/image_file", {"renderer/image/image.h"}},
    {"client/commands_compare.cc", {"renderer/image/"}},
    {"client/client.h", {"halfshade/v1/", "server/server.h"}},                  // the service in the client's process
    {"client/commands_server.cc", {"halfshade/v1/", "renderer/gl/context.h"}},  // doctor
};

// Who may reach a foreign header, directly or through headers of the project. Tests may reach anything.
struct Foreign {
  Strings headers;
  Strings rooms;
};
const std::vector<Foreign> kForeign = {
    // The renderer knows nothing of the wire, of files on disk (but the cgroup's CPU quota), or of logs.
    {{"grpc", "google/protobuf/", "halfshade/v1/"}, {"server/", "client/"}},
    {{"fstream", "filesystem", "fcntl.h", "sys/stat.h"}, {"server/", "client/", "renderer/gl/driver_threads.cc"}},
    {{"spdlog/", "CLI/", "openssl/", "OpenImageIO/", "CivetServer.h"}, {"server/", "client/"}},
    // Rooms that are tested without a context see no GL.
    {{"glad/", "EGL/", "GL/"},
     {"renderer/gl/", "renderer/scene/scene_on_context", "renderer/light/", "renderer/shadow/", "renderer/shade/",
      "renderer/renderer.", "renderer/frame.", "renderer/light_layers.", "renderer/light_view.", "renderer/seen_view.",
      "renderer/passes.", "renderer/prepare_light.", "renderer/query.", "renderer/soft_shadow_map.",
      "renderer/warm_up.", "server/", "client/"}},
    {{"embree"}, {"renderer/scene/ray_", "renderer/light/trace_"}},
    {{"tbb/"}, {"renderer/scene/ray_", "renderer/light/parallel_for", "renderer/shadow/pdsm/"}},
    {{"hwy/"}, {"renderer/shadow/pdsm/", "renderer/shadow/shaft/", "renderer/shadow/ssm/"}},
    {{"meshoptimizer"}, {"renderer/scene/mesh_levels", "renderer/scene_loader/decompress.cc"}},
    {{"draco/"}, {"renderer/scene_loader/decompress.cc"}},
    {{"tiny_gltf", "stb"}, {"renderer/scene_loader/"}},
    {{"tiny_obj_loader"}, {"client/"}},
};

const Strings kNamesWithoutReason = {"util", "utils", "common", "misc", "helpers"};
const Strings kAllowedAnyway = {"shaders/common"};  // GLSL that several passes share

bool StartsWithAny(const std::string& text, const Strings& prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(), [&](const std::string& p) { return text.starts_with(p); });
}

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string FolderOf(const std::string& file) { return file.substr(0, file.rfind('/') + 1); }

// C++ files of the project by path from the root, with what each includes.
using Includes = std::map<std::string, Strings>;
Includes ReadIncludes(const fs::path& root) {
  static const std::regex include(R"([ \t]*#[ \t]*include[ \t]*[<"]([^>"]+)[>"].*)");
  Includes includes;
  for (const char* top : {"renderer", "server", "client", "tests"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (entry.path().extension() != ".cc" && entry.path().extension() != ".h") continue;
      Strings& targets = includes[fs::relative(entry.path(), root).string()];
      std::istringstream text(ReadFile(entry.path()));
      std::smatch match;
      for (std::string line; std::getline(text, line);) {
        if (std::regex_match(line, match, include)) targets.push_back(match[1]);
      }
    }
  }
  return includes;
}

// Null: the table has no room for the file.
const Room* RoomOf(const std::string& file) {
  const Room* best = nullptr;
  for (const Room& room : kRooms) {
    if (file.starts_with(room.path) && (best == nullptr || room.path.size() > best->path.size())) best = &room;
  }
  return best;
}

Strings FindForbiddenRooms(const Includes& includes) {
  static const Strings project = {"renderer/", "server/", "client/", "tests/", "halfshade/v1/"};
  Strings found;
  for (const auto& [file, targets] : includes) {
    if (file.starts_with("tests/")) continue;
    const Room* room = RoomOf(file);
    if (room == nullptr) {
      found.push_back(file + " is in no room of the table");
      continue;
    }
    for (const std::string& target : targets) {
      const bool is_allowed = !StartsWithAny(target, project) || FolderOf(target) == FolderOf(file) ||
                              StartsWithAny(target, kVocabulary) || StartsWithAny(target, room->may_include);
      if (!is_allowed) found.push_back(file + " includes " + target);
    }
  }
  return found;
}

// Visits what `file` includes and what that includes; `path` is how it came there.
template <typename Visit>
void VisitReached(const Includes& includes, const std::string& file, std::map<std::string, std::string>& path_of,
                  const Visit& visit) {
  const auto entry = includes.find(file);
  if (entry == includes.end()) return;
  for (const std::string& target : entry->second) {
    if (!path_of.emplace(target, path_of[file] + " -> " + target).second) continue;
    visit(target, path_of[target]);
    VisitReached(includes, target, path_of, visit);
  }
}

Strings FindForbiddenForeign(const Includes& includes) {
  Strings found;
  for (const auto& [file, targets] : includes) {
    if (file.starts_with("tests/")) continue;
    std::map<std::string, std::string> path_of = {{file, file}};
    VisitReached(includes, file, path_of, [&, &file = file](const std::string& target, const std::string& path) {
      for (const Foreign& foreign : kForeign) {
        if (StartsWithAny(target, foreign.headers) && !StartsWithAny(file, foreign.rooms)) found.push_back(path);
      }
    });
  }
  return found;
}

// Tests that no target builds, by what the build has written down about itself.
Strings FindUnbuiltTests(const fs::path& root, const Includes& includes, const std::string& compile_commands) {
  Strings found;
  for (const auto& [file, targets] : includes) {
    const std::string line = "\"file\": \"" + (root / file).string() + "\"";
    if (file.ends_with("_test.cc") && compile_commands.find(line) == std::string::npos) found.push_back(file);
  }
  return found;
}

Strings FindNamesWithoutReason(const fs::path& root) {
  Strings found;
  for (const char* top : {"renderer", "server", "client", "tests", "shaders", "proto", "docker"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (!entry.is_directory()) continue;
      const std::string path = fs::relative(entry.path(), root).string();
      const std::string name = entry.path().filename().string();
      const bool has_none =
          std::find(kNamesWithoutReason.begin(), kNamesWithoutReason.end(), name) != kNamesWithoutReason.end();
      if (has_none && !StartsWithAny(path, kAllowedAnyway)) found.push_back(path);
    }
  }
  return found;
}

const fs::path kRoot = HALFSHADE_SOURCE_DIR;

TEST(LayersTest, NoRoomIncludesWhatItMustNotKnow) {
  const Includes includes = ReadIncludes(kRoot);
  ASSERT_GT(includes.size(), 100u) << "the checker must see the project";
  EXPECT_EQ(FindForbiddenRooms(includes), Strings());
}

TEST(LayersTest, NoRoomReachesAForeignHeaderThatItMustNotKnow) {
  EXPECT_EQ(FindForbiddenForeign(ReadIncludes(kRoot)), Strings());
}

TEST(LayersTest, EveryPathOfTheTablesExists) {
  const Includes includes = ReadIncludes(kRoot);
  const auto exists = [&](const std::string& prefix) {
    return prefix == "halfshade/v1/" || std::any_of(includes.begin(), includes.end(),
                                                    [&](const auto& file) { return file.first.starts_with(prefix); });
  };
  for (const Room& room : kRooms) {
    EXPECT_TRUE(exists(room.path)) << room.path;
    for (const std::string& target : room.may_include) EXPECT_TRUE(exists(target)) << target;
  }
  for (const Foreign& foreign : kForeign) {
    for (const std::string& room : foreign.rooms) EXPECT_TRUE(exists(room)) << room;
  }
}

TEST(LayersTest, EveryTestFileIsBuilt) {
  EXPECT_EQ(FindUnbuiltTests(kRoot, ReadIncludes(kRoot), ReadFile(HALFSHADE_COMPILE_COMMANDS)), Strings());
}

TEST(LayersTest, NoRoomIsNamedForNothing) { EXPECT_EQ(FindNamesWithoutReason(kRoot), Strings()); }

// Negative controls: what is planted is found, and nothing else.
class PlantedFaultTest : public testing::Test {
 protected:
  PlantedFaultTest() : root_(fs::temp_directory_path() / ("layers_test_" + std::to_string(getpid()))) {}
  ~PlantedFaultTest() override { fs::remove_all(root_); }

  void Plant(const std::string& path, const std::string& text) const {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }

  const fs::path root_;
};

TEST_F(PlantedFaultTest, AnIncludeUpwardsIsFound) {
  Plant("renderer/math/a.cc", "#include \"renderer/math/a.h\"\n#include \"renderer/gl/context.h\"\n#include <cmath>\n");
  Plant("renderer/shadow/ssm/b.cc", "#include \"renderer/shadow/pdsm/c.h\"\n#include \"renderer/shadow/ssm/b.h\"\n");
  Plant("renderer/light/d.h", "  #  include \"server/server.h\"  // no\n");
  Plant("renderer/new_room/e.h", "#pragma once\n");
  Plant("tests/renderer/f_test.cc", "#include \"server/server.h\"\n");
  EXPECT_EQ(FindForbiddenRooms(ReadIncludes(root_)),
            Strings({"renderer/light/d.h includes server/server.h", "renderer/math/a.cc includes renderer/gl/context.h",
                     "renderer/new_room/e.h is in no room of the table",
                     "renderer/shadow/ssm/b.cc includes renderer/shadow/pdsm/c.h"}));
}

TEST_F(PlantedFaultTest, AForeignHeaderIsFoundThroughAnotherHeader) {
  Plant("renderer/scene/flat_scene.h", "#include <glad/gl.h>\n");
  Plant("renderer/plan/a.cc", "#include \"renderer/scene/flat_scene.h\"\n");
  Plant("renderer/renderer.cc", "#include <grpcpp/server.h>\n#include <glad/gl.h>\n");
  Plant("server/b.cc", "#include <tiny_gltf.h>\n#include <grpcpp/server.h>\n");
  EXPECT_EQ(FindForbiddenForeign(ReadIncludes(root_)),
            Strings({"renderer/plan/a.cc -> renderer/scene/flat_scene.h -> glad/gl.h",
                     "renderer/renderer.cc -> grpcpp/server.h", "renderer/scene/flat_scene.h -> glad/gl.h",
                     "server/b.cc -> tiny_gltf.h"}));
}

TEST_F(PlantedFaultTest, AForgottenTestIsFound) {
  Plant("tests/x/forgotten_test.cc", "\n");
  Plant("tests/x/built_test.cc", "\n");
  const std::string commands = "\"file\": \"" + (root_ / "tests/x/built_test.cc").string() + "\"\n";
  EXPECT_EQ(FindUnbuiltTests(root_, ReadIncludes(root_), commands), Strings({"tests/x/forgotten_test.cc"}));
}

TEST_F(PlantedFaultTest, ARoomNamedForNothingIsFound) {
  Plant("server/util/a.h", "\n");
  Plant("shaders/common/a.glsl", "\n");
  EXPECT_EQ(FindNamesWithoutReason(root_), Strings({"server/util"}));
}

}  // namespace
