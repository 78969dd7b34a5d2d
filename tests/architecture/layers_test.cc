// Holds the sources to the plan of the house: what a room may include, and that every test is registered.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

// A file whose path begins with `room` must not include what begins with any of `forbidden` (but for `except`).
struct Rule {
  std::string room;
  std::vector<std::string> forbidden;
  std::vector<std::string> except;
};

const std::vector<Rule>& Rules() {
  static const std::vector<Rule> rules = {
      // The renderer knows nothing of protobuf, gRPC, files on disk, or the rooms that use it.
      {"renderer/", {"server/", "client/", "tests/", "halfshade/v1/", "grpc", "google/protobuf", "fstream", "filesystem", "spdlog", "CLI/"}, {"renderer/gl/driver_threads.cc"}},  // which reads the cgroup's CPU quota
      // Pure rooms.
      {"renderer/math/", {"renderer/gl/", "glad/", "renderer/scene/", "renderer/light/", "renderer/shadow/", "renderer/shade/", "renderer/plan/"}, {}},
      {"renderer/image/", {"renderer/gl/", "glad/", "renderer/scene/", "renderer/light/", "renderer/shadow/", "renderer/shade/", "renderer/plan/"}, {}},
      {"renderer/plan/", {"renderer/gl/", "glad/", "renderer/light/", "renderer/shadow/", "renderer/shade/"}, {}},
      // Nothing flows back up.
      {"renderer/gl/", {"renderer/scene/", "renderer/plan/", "renderer/light/", "renderer/shadow/", "renderer/shade/"}, {}},
      {"renderer/scene/", {"renderer/plan/", "renderer/light/", "renderer/shadow/", "renderer/shade/", "renderer/scene_loader/"}, {}},
      {"renderer/light/", {"renderer/plan/", "renderer/shadow/", "renderer/shade/", "renderer/scene_loader/"}, {}},
      {"renderer/shadow/", {"renderer/plan/", "renderer/shade/", "renderer/scene_loader/"}, {}},
      {"renderer/shade/", {"renderer/shadow/", "renderer/scene_loader/"}, {}},
      // A method's room never includes another method's room; the registry alone knows them all.
      {"renderer/shadow/hard/", {"renderer/shadow/multi_map/"}, {}},
      {"renderer/shadow/multi_map/", {"renderer/shadow/hard/"}, {}},
      // The loader makes flat scenes and knows no GL; nothing else includes tinygltf.
      {"renderer/scene_loader/", {"renderer/gl/", "glad/", "renderer/plan/", "renderer/light/", "renderer/shadow/", "renderer/shade/"}, {}},
      {"", {"tiny_gltf"}, {"renderer/scene_loader/", "tests/architecture/"}},
      {"server/", {"client/", "tests/"}, {}},
      {"client/", {"tests/", "renderer/light/", "renderer/shadow/", "renderer/shade/"}, {}},
  };
  return rules;
}

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

bool StartsWithAny(const std::string& text, const std::vector<std::string>& prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(), [&](const std::string& p) { return text.starts_with(p); });
}

// Files of the project below `root`, by relative path.
std::vector<std::string> Sources(const fs::path& root) {
  std::vector<std::string> files;
  for (const char* room : {"renderer", "server", "client", "tests"}) {
    if (!fs::exists(root / room)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / room)) {
      const std::string extension = entry.path().extension();
      if (extension == ".cc" || extension == ".h") files.push_back(fs::relative(entry.path(), root));
    }
  }
  return files;
}

std::vector<std::string> FindForbiddenIncludes(const fs::path& root) {
  static const std::regex include(R"(#include\s*[<"]([^>"]+)[>"])");
  std::vector<std::string> found;
  for (const std::string& file : Sources(root)) {
    const std::string text = ReadFile(root / file);
    for (auto match = std::sregex_iterator(text.begin(), text.end(), include); match != std::sregex_iterator(); ++match) {
      const std::string target = (*match)[1];
      for (const Rule& rule : Rules()) {
        if (file.starts_with(rule.room) && !StartsWithAny(file, rule.except) && StartsWithAny(target, rule.forbidden)) {
          found.push_back(file + " includes " + target);
        }
      }
    }
  }
  return found;
}

std::vector<std::string> FindUnregisteredTests(const fs::path& root) {
  std::vector<std::string> found;
  for (const std::string& file : Sources(root)) {
    if (!file.ends_with("_test.cc")) continue;
    const fs::path path = root / file;
    const std::string list = ReadFile(path.parent_path() / "CMakeLists.txt");
    if (list.find(path.filename().string()) == std::string::npos) found.push_back(file);
  }
  return found;
}

const fs::path kRoot = HALFSHADE_SOURCE_DIR;

TEST(LayersTest, NoRoomIncludesWhatStandsBelowIt) {
  EXPECT_GT(Sources(kRoot).size(), 100u) << "the checker must see the project";
  for (const std::string& found : FindForbiddenIncludes(kRoot)) ADD_FAILURE() << found;
}

TEST(LayersTest, EveryTestFileIsRegistered) {
  for (const std::string& found : FindUnregisteredTests(kRoot)) ADD_FAILURE() << found << " is in no CMakeLists.txt";
}

TEST(LayersTest, NoRoomIsNamedForNothing) {
  for (const char* room : {"renderer", "server", "client", "tests", "shaders"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / room)) {
      if (!entry.is_directory() || fs::relative(entry.path(), kRoot) == "shaders/common") continue;
      const std::string name = entry.path().filename();
      EXPECT_TRUE(name != "util" && name != "utils" && name != "common" && name != "misc" && name != "helpers") << entry.path();
    }
  }
}

// Negative control: a planted violation of each kind is found.
TEST(LayersTest, PlantedViolationsAreFound) {
  const fs::path root = fs::temp_directory_path() / ("layers_test_" + std::to_string(getpid()));
  fs::create_directories(root / "renderer/math");
  fs::create_directories(root / "tests/x");
  std::ofstream(root / "renderer/math/bad.cc") << "#include \"renderer/gl/context.h\"\n#include <tiny_gltf.h>\n";
  std::ofstream(root / "tests/x/forgotten_test.cc") << "\n";
  std::ofstream(root / "tests/x/CMakeLists.txt") << "other_test.cc\n";
  EXPECT_EQ(FindForbiddenIncludes(root).size(), 2u);
  EXPECT_EQ(FindUnregisteredTests(root).size(), 1u);
  fs::remove_all(root);
}

}  // namespace
