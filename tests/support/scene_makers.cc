#include "tests/support/scene_makers.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "renderer/math/camera.h"
#include "tests/support/mesh_parts.h"
#include "tests/support/scene_classes.h"

namespace halfshade {
namespace {

constexpr double kGoldenAngle = 2.399963229728653;

glm::vec4 Gray(float value) { return {value, value, value, 1}; }

// A leaf on its stem: both bend under their weight.
void AddLeaf(GlbMesh& leaves, GlbMesh& stems, double angle, double rise, double reach, double width) {
  const glm::dvec3 out(std::cos(angle), 0, std::sin(angle));
  const glm::dvec3 side(-std::sin(angle), 0, std::cos(angle));
  const glm::dvec3 root(0, 0.38, 0);
  const auto spine = [&](double t) {
    return root + out * (reach * t) + glm::dvec3(0, rise * t - 0.75 * reach * t * t * t, 0);
  };
  constexpr double kStem = 0.42;  // of the spine
  AddGrid(leaves, 8, 16, [&](double s, double t) {
    const double along = kStem + (1 - kStem) * t;
    const double outline = width * std::pow(std::sin(M_PI * std::min(1.0, std::max(0.0, 0.02 + 0.97 * t))), 0.8);
    const double across = (2 * s - 1) * outline;
    return spine(along) + side * across + glm::dvec3(0, -0.9 * across * across / width, 0);
  });
  AddGrid(stems, 8, 10, [&](double s, double t) {
    const double turn = 2 * M_PI * s;
    const double radius = 0.008 * (1.3 - t);
    return spine(kStem * 1.05 * t) + side * (radius * std::cos(turn)) + glm::dvec3(0, radius * std::sin(turn), 0);
  });
}

MadeScene MakePlant(uint32_t seed) {
  GlbMesh pot, soil, leaves, stems;
  pot.name = "pot";
  pot.base_color = {0.55f, 0.24f, 0.14f, 1};
  pot.is_double_sided = true;
  AddRevolution(pot, {0, 0, 0}, 64, 24, [](double t) {
    const double height = 0.42 * t;
    return glm::dvec2(0.2 + 0.1 * t + (t > 0.84 ? 0.025 : 0.0), height);
  });
  soil.name = "soil";
  soil.base_color = {0.09f, 0.06f, 0.045f, 1};
  AddRevolution(soil, {0, 0, 0}, 64, 2, [](double t) { return glm::dvec2(0.29 * (1 - t), 0.36 + 0.02 * t); });
  leaves.name = "leaves";
  leaves.base_color = {0.16f, 0.42f, 0.13f, 1};
  leaves.is_double_sided = true;
  stems.name = "stems";
  stems.base_color = {0.25f, 0.35f, 0.12f, 1};
  stems.is_double_sided = true;
  std::mt19937 random(11 + seed);
  const auto unit = [&random] { return double(random() >> 8) / double(1 << 24); };
  for (int i = 0; i < 26; ++i) {
    const double up = 1 - i / 26.0;
    AddLeaf(leaves, stems, kGoldenAngle * i, 0.35 + 1.15 * up + 0.1 * unit(), 0.45 + 0.35 * (1 - up) + 0.1 * unit(),
            0.085 + 0.035 * unit());
  }
  MadeScene scene;
  scene.meshes = {pot, soil, leaves, stems};
  scene.eye = {1.5, 1.55, 2.6};
  scene.target = {0.15, 0.5, 0};
  scene.light_center = {-1.7, 2.9, 1.0};
  scene.light_target = {0, 0.5, 0};
  scene.light_edge_m = 0.6;
  scene.ground_size_m = 9;
  return scene;
}

MadeScene MakeColonnade() {
  GlbMesh steps, columns, beams;
  steps.name = "steps";
  steps.base_color = Gray(0.55f);
  for (int i = 0; i < 3; ++i) {
    const double inset = 0.25 * i;
    AddBox(steps, {-4.2 + inset, 0.18 * i, -1.9 + inset}, {4.2 - inset, 0.18 * (i + 1), 1.9 - inset});
  }
  columns.name = "columns";
  columns.base_color = {0.72f, 0.68f, 0.6f, 1};
  columns.is_double_sided = true;
  beams.name = "beams";
  beams.base_color = {0.66f, 0.62f, 0.55f, 1};
  constexpr double kFloor = 0.54, kHeight = 2.9;
  for (const double z : {-0.95, 0.95}) {
    for (int i = 0; i < 6; ++i) {
      const double x = -3.2 + 1.28 * i;
      AddBox(columns, {x - 0.27, kFloor, z - 0.27}, {x + 0.27, kFloor + 0.1, z + 0.27});
      // Entasis: the shaft swells a little and narrows toward the top.
      AddRevolution(columns, {x, kFloor + 0.1, z}, 40, 16, [](double t) {
        return glm::dvec2(0.21 - 0.05 * t + 0.02 * std::sin(M_PI * t), (kHeight - 0.22) * t);
      });
      AddBox(columns, {x - 0.25, kFloor + kHeight - 0.12, z - 0.25}, {x + 0.25, kFloor + kHeight, z + 0.25});
    }
    AddBox(beams, {-3.6, kFloor + kHeight, z - 0.24}, {3.6, kFloor + kHeight + 0.35, z + 0.24});
  }
  for (int i = 0; i < 11; ++i) {
    const double x = -3.4 + 0.68 * i;
    AddBox(beams, {x - 0.07, kFloor + kHeight + 0.35, -1.45}, {x + 0.07, kFloor + kHeight + 0.5, 1.45});
  }
  MadeScene scene;
  scene.meshes = {steps, columns, beams};
  scene.eye = {5.4, 3.4, 7.6};
  scene.target = {0.2, 1.35, 0};
  scene.light_center = {-6.5, 8.5, 5.0};
  scene.light_target = {0, 1, 0};
  scene.light_edge_m = 1.3;
  scene.ground_size_m = 30;
  return scene;
}

}  // namespace

std::vector<std::string> SceneNames() {
  std::vector<std::string> names = SceneClassNames();
  names.insert(names.end(), {"plant", "colonnade"});
  return names;
}

MadeScene MakeScene(const std::string& name, const SceneOptions& options) {
  MadeScene scene = name == "plant"       ? MakePlant(options.seed)
                    : name == "colonnade" ? MakeColonnade()
                                          : MakeSceneClass(name, options.triangles, options.seed);
  if (options.light_share > 0) scene.light_edge_m = options.light_share * OccluderExtent(scene);
  return scene;
}

std::vector<NodeOverride> OverridesAt(const MadeScene& scene, double time_s) {
  std::vector<NodeOverride> overrides;
  for (const MovingNode& node : scene.moving) {
    NodeOverride& change = overrides.emplace_back();
    change.node = node.mesh;
    change.local = node.world_from_mesh(time_s);
    change.casts = false;
  }
  return overrides;
}

double OccluderExtent(const MadeScene& scene) {
  std::set<size_t> moving;
  for (const MovingNode& node : scene.moving) moving.insert(node.mesh);
  Box3d bounds;
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    if (moving.contains(i)) continue;
    for (const glm::vec3& p : scene.meshes[i].positions) bounds.Add(p);  // still meshes stand in the world as they are
  }
  const glm::dvec3 extent = bounds.Extent();
  return std::max({extent.x, extent.y, extent.z});
}

RenderRequest RequestFor(const MadeScene& scene) {
  RenderRequest request;
  request.camera = *MakeLookAtCamera(scene.eye, scene.target, {0, 1, 0});
  request.camera.tan_half_fovy = std::tan(scene.fovy_deg * M_PI / 360);
  request.camera.near_m = 1e-2 * glm::distance(scene.eye, scene.target);
  request.ground = Ground{scene.ground_height_m, scene.ground_size_m, false};
  AreaLight light;
  const glm::dvec3 view = scene.light_target - scene.light_center;
  light.center_ws = scene.light_center;
  light.normal_ws = glm::normalize(view);
  const glm::dvec3 across = glm::cross(glm::dvec3(0, 1, 0), light.normal_ws);
  light.axis_u_ws = glm::length(across) > 1e-6 ? glm::normalize(across) : glm::dvec3(1, 0, 0);
  light.axis_v_ws = glm::cross(light.normal_ws, light.axis_u_ws);
  light.width_m = light.height_m = scene.light_edge_m;
  // A white surface at the light's target that faces it reflects about 1.
  light.radiance = glm::vec3(float(M_PI * glm::dot(view, view) / (scene.light_edge_m * scene.light_edge_m)));
  request.lights = {light};
  return request;
}

std::string ViewFileText(const MadeScene& scene, const std::string& scene_path) {
  const auto list = [](const glm::dvec3& v) { return nlohmann::ordered_json{v.x, v.y, v.z}; };
  const AreaLight light = RequestFor(scene).lights[0];
  nlohmann::ordered_json view;
  view["scene"] = scene_path;
  view["camera"] = {
      {"eye", list(scene.eye)}, {"target", list(scene.target)}, {"up", {0, 1, 0}}, {"fovy_deg", scene.fovy_deg}};
  view["light"] = {{"center", list(light.center_ws)}, {"normal", list(light.normal_ws)}, {"u", list(light.axis_u_ws)},
                   {"v", list(light.axis_v_ws)},      {"width", light.width_m},          {"height", light.height_m}};
  view["ground"] = {{"y", scene.ground_height_m}, {"size", scene.ground_size_m}, {"add", true}};
  return view.dump(1) + "\n";
}

std::string PoseFileText(const MadeScene& scene, double time_s) {
  nlohmann::ordered_json changes = nlohmann::ordered_json::array();
  for (const NodeOverride& change : OverridesAt(scene, time_s)) {
    std::vector<double> columns;
    for (int i = 0; i < 16; ++i) columns.push_back((*change.local)[i / 4][i % 4]);
    changes.push_back({{"name", scene.meshes[change.node].name}, {"transform", columns}, {"casts", change.casts}});
  }
  return nlohmann::ordered_json{{"nodeOverrides", changes}}.dump(1) + "\n";
}

}  // namespace halfshade
