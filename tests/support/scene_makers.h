// Scenes made by rule: for the demo, the tests and the bench. The same name gives the same bytes.
#pragma once

#include <string>
#include <vector>

#include "client/glb_writer.h"

namespace halfshade {

struct MadeScene {
  std::vector<GlbMesh> meshes;
  // What shows it: world metres, y up.
  glm::dvec3 eye{0}, target{0};
  double fovy_deg = 40;
  glm::dvec3 light_center{0}, light_target{0};
  double light_edge_m = 1;
  double ground_height_m = 0, ground_size_m = 1;
};

// "plant": curved leaves on stems in a pot. "colonnade": steps, two rows of columns, a beam on each.
std::vector<std::string> SceneNames();
// Nothing meaningful for a name that is not in SceneNames (asserted).
MadeScene MakeScene(const std::string& name);

// The scene's camera, light and ground in the form of a view file (`halfshade render --view`).
std::string ViewFileText(const MadeScene& scene, const std::string& scene_path);

}  // namespace halfshade
