#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "renderer/scene/pose.h"
#include "renderer/scene_loader/build_motion.h"

namespace halfshade {
namespace {

Json Vector(const glm::dvec3& v) { return {{"x", v.x}, {"y", v.y}, {"z", v.z}}; }
Json Color(const glm::dvec3& c) { return {{"r", c.x}, {"g", c.y}, {"b", c.z}}; }

// Right-angled within what v1.AreaLight asks.
constexpr double kRightAngle = 1e-3;

// The corner of `p` at which two edges of a rectangle meet at right angles, as [corner, along u, along v].
std::optional<std::array<glm::dvec3, 3>> RightCorner(const std::array<glm::dvec3, 3>& p) {
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 u = p[(i + 1) % 3] - p[i], v = p[(i + 2) % 3] - p[i];
    if (std::abs(glm::dot(u, v)) <= kRightAngle * glm::length(u) * glm::length(v)) {
      return std::array<glm::dvec3, 3>{p[i], p[(i + 1) % 3], p[(i + 2) % 3]};
    }
  }
  return std::nullopt;
}

// Two triangles that make a rectangle, in the world: the first one's right corner and the second one's opposite it.
std::optional<Json> EmittingRectangle(const FlatScene& scene, const Instance& instance) {
  const Mesh& mesh = scene.meshes[instance.mesh];
  const Material& material = scene.materials[mesh.material];
  if (mesh.index_count != 6 || material.emissive == glm::vec3(0) || material.emissive_texture.texture >= 0) {
    return std::nullopt;
  }
  std::array<glm::dvec3, 3> corners[2];
  for (uint32_t i = 0; i < 6; ++i) {
    const glm::vec3& position = scene.positions[mesh.first_vertex + scene.indices[mesh.first_index + i]];
    corners[i / 3][i % 3] = glm::dvec3(instance.world_from_mesh * glm::dvec4(position, 1));
  }
  const auto first = RightCorner(corners[0]), second = RightCorner(corners[1]);
  if (!first || !second) return std::nullopt;
  const glm::dvec3 u = (*first)[1] - (*first)[0], v = (*first)[2] - (*first)[0];
  const double slack = kRightAngle * (glm::length(u) + glm::length(v));
  if (glm::distance((*second)[0], (*first)[0] + u + v) > slack) return std::nullopt;
  Json light = {{"center", Vector((*first)[0] + (u + v) / 2.0)},
                {"edgeU", Vector(u)},
                {"edgeV", Vector(v)},
                {"radiance", Color(material.emissive)}};
  // Counter-clockwise as a front face is: u, v in the order of the triangle give the side that it shows.
  const bool is_mirrored = glm::determinant(glm::dmat3(instance.world_from_mesh)) < 0;
  light["direction"] = Vector(glm::normalize(glm::cross(u, v)) * (is_mirrored ? -1.0 : 1.0));
  if (material.is_double_sided) light["twoSided"] = true;
  return light;
}

}  // namespace

void SuggestLights(const Gltf& gltf, const FlatScene& scene, Warnings* warnings) {
  const std::vector<glm::dmat4> world = WorldFromNodes(scene);
  for (const auto& [node, extensions] : gltf.node_extensions) {
    if (!extensions.is_object() || !extensions.contains("KHR_lights_punctual")) continue;
    const Json& light = gltf.lights[extensions["KHR_lights_punctual"]["light"].get<size_t>()];
    const std::string pointer = "/nodes/" + std::to_string(node) + "/extensions/KHR_lights_punctual";
    const std::string type = light["type"];
    if (type == "directional") warnings->Add(pointer, "a directional light; an area light far away comes close to it");
    if (type != "point" && type != "spot") continue;
    const double intensity = light.value("intensity", 1.0);
    const glm::dvec3 color = light.contains("color")
                                 ? glm::dvec3(light["color"][0].get<double>(), light["color"][1].get<double>(),
                                              light["color"][2].get<double>())
                                 : glm::dvec3(1);
    const glm::dvec3 along = -glm::dvec3(world[node][2]);
    const double length = glm::length(along);
    // A point light of ours shines along one direction; of one that shines everywhere the half that is down.
    const glm::dvec3 down(0, -1, 0);
    const glm::dvec3 direction = type == "spot" && std::isfinite(length) && length > 0 ? along / length : down;
    const Json suggestion = {{"center", Vector(glm::dvec3(world[node][3]))},
                             {"direction", Vector(direction)},
                             {"intensity", Color(color * intensity)}};
    warnings->Add(pointer, "lights nothing by itself; as a light of a request: " + suggestion.dump());
  }
  const auto emits = [&](const Mesh& mesh) {
    return mesh.index_count == 6 && scene.materials[mesh.material].emissive != glm::vec3(0);
  };
  if (std::none_of(scene.meshes.begin(), scene.meshes.end(), emits)) return;
  const absl::StatusOr<Pose> pose = BuildPose(scene, scene.default_scene);
  for (size_t i = 0; pose.ok() && i < pose->instances.size(); ++i) {
    if (const auto light = EmittingRectangle(scene, pose->instances[i])) {
      warnings->Add("/nodes/" + std::to_string(pose->instances[i].node),
                    "shines but lights nothing by itself; as a light of a request: " + light->dump());
    }
  }
}

}  // namespace halfshade
