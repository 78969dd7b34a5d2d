// make_scene NAME OUT.glb [--view OUT.json] [--pose OUT.json --time T] [--triangles N] [--seed S] [--light SHARE]:
// writes a scene made by rule, a view file that shows it, and where its moving nodes are at a time.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

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
  CLI::App app("Writes a scene made by rule.", "make_scene");
  std::string name, out, view, pose;
  double time_s = 0;
  halfshade::SceneOptions options;
  app.add_option("NAME", name)->required()->check(CLI::IsMember(halfshade::SceneNames()));
  app.add_option("OUT.glb", out)->required();
  app.add_option("--view", view, "also write a view file that shows the scene");
  CLI::Option* triangles =
      app.add_option("--triangles", options.triangles, "about so many; S1 to S8")->check(CLI::Range(2u, 20'000'000u));
  app.add_option("--seed", options.seed, "of what is random: S5, S6, S7, plant");
  app.add_option("--light", options.light_share, "edge of the light over the scene's longest edge")
      ->check(CLI::Range(1e-6, 100.0));
  CLI::Option* pose_option = app.add_option("--pose", pose, "also write a request that poses the moving nodes; S8");
  app.add_option("--time", time_s, "of the pose, seconds")->needs(pose_option)->check(CLI::Range(-1e6, 1e6));
  try {
    app.parse(argc, argv);
    if (triangles->count() > 0 && name.front() != 'S') {
      throw CLI::ValidationError("--triangles", name + " has a fixed number of triangles");
    }
    if (!pose.empty() && name != "S8") throw CLI::ValidationError("--pose", "nothing moves in " + name);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 64;
  }
  const halfshade::MadeScene scene = halfshade::MakeScene(name, options);
  if (!WriteFile(out, halfshade::WriteGlb(scene.meshes))) return 74;
  if (!view.empty() && !WriteFile(view, halfshade::ViewFileText(scene, std::filesystem::absolute(out)))) return 74;
  if (!pose.empty() && !WriteFile(pose, halfshade::PoseFileText(scene, time_s))) return 74;
  return 0;
}
