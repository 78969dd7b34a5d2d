// Scenes made by rule: for the demo, the tests and the bench. The same name and options give the same bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/glb_writer.h"
#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

// A node that goes round: what it receives changes, what the light's occluders are does not, for it casts nothing.
struct MovingNode {
  uint32_t mesh = 0;  // into MadeScene::meshes, and so the node's index in the file; its name is the mesh's
  double period_s = 1;
  std::function<glm::dmat4(double time_s)> world_from_mesh;  // rigid; at 0 the mesh's own
};

// As the wire has it (Fog of render.proto).
struct MadeFog {
  double density_per_m = 0;
  glm::dvec3 albedo{1};
  double falloff_height_m = 0;  // 0: homogeneous
  double ground_m = 0;
};

struct MadeScene {
  std::vector<GlbMesh> meshes;
  std::vector<MovingNode> moving;  // S8
  std::optional<MadeFog> fog;      // S8
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

// What to change of the scene's nodes at a time: the moving ones' places, and that they cast nothing.
std::vector<NodeOverride> OverridesAt(const MadeScene& scene, double time_s);

// Longest edge of the bounding box of what does not move, metres.
double OccluderExtent(const MadeScene& scene);

// A request with the scene's camera, light and ground; all else as in RenderRequest{}: nothing is overridden, no fog.
RenderRequest RequestFor(const MadeScene& scene);

// The scene's camera, light and ground in the form of a view file (`halfshade render --view`).
std::string ViewFileText(const MadeScene& scene, const std::string& scene_path);

// OverridesAt as a RenderRequest in proto JSON (`halfshade render --request`), nodes by name.
std::string PoseFileText(const MadeScene& scene, double time_s);

}  // namespace halfshade
