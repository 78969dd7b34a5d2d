// make_scene NAME OUT.glb [--view OUT.json]: writes a scene made by rule, and a view file that shows it.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/scene_makers.h"

namespace {

bool WriteFile(const std::string& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file << bytes;
  file.close();
  if (!file) std::fprintf(stderr, "make_scene: cannot write %s\n", path.c_str());
  return bool(file);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> names = halfshade::SceneNames();
  std::vector<std::string> plain;
  std::string view;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--view" && i + 1 < argc) {
      view = argv[++i];
    } else {
      plain.emplace_back(argv[i]);
    }
  }
  const bool is_known = !plain.empty() && std::find(names.begin(), names.end(), plain[0]) != names.end();
  if (plain.size() != 2 || !is_known) {
    std::fprintf(stderr, "usage: make_scene NAME OUT.glb [--view OUT.json]\nNAME:");
    for (const std::string& name : names) std::fprintf(stderr, " %s", name.c_str());
    std::fprintf(stderr, "\n");
    return 64;
  }
  const halfshade::MadeScene scene = halfshade::MakeScene(plain[0]);
  if (!WriteFile(plain[1], halfshade::WriteGlb(scene.meshes))) return 74;
  if (!view.empty() && !WriteFile(view, halfshade::ViewFileText(scene, std::filesystem::absolute(plain[1])))) return 74;
  return 0;
}
