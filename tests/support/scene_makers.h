// Scenes made by rule: for the demo, the tests and the bench. The same name and options give the same bytes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/glb_writer.h"
#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"

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

struct SceneOptions {
  uint32_t triangles = 0;  // about, for the classes (scene_classes.h); 0: the scene's own number
  uint32_t seed = 0;       // of what is random: S5, S6, S7, plant
  double light_share = 0;  // edge of the light over OccluderExtent; 0: the scene's own light
};

// The classes of scene_classes.h, and "plant": curved leaves on stems in a pot; "colonnade": steps, two rows of
// columns, a beam on each.
std::vector<std::string> SceneNames();
// Requires a name of SceneNames (asserted).
MadeScene MakeScene(const std::string& name, const SceneOptions& options = {});

// Longest edge of the meshes' bounding box, metres.
double OccluderExtent(const MadeScene& scene);

// A request with the scene's camera, light and ground; all else as in RenderRequest{}.
RenderRequest RequestFor(const MadeScene& scene);

// The scene's camera, light and ground in the form of a view file (`halfshade render --view`).
std::string ViewFileText(const MadeScene& scene, const std::string& scene_path);

}  // namespace halfshade
