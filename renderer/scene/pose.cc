#include "renderer/scene/pose.h"

#include <glm/gtc/matrix_transform.hpp>
#include <string>

namespace halfshade {

glm::dmat4 WorldFromNode(const FlatScene& scene, uint32_t node) {
  glm::dmat4 world = scene.nodes[node].local;
  for (int32_t parent = scene.nodes[node].parent; parent >= 0; parent = scene.nodes[parent].parent) {
    world = scene.nodes[parent].local * world;
  }
  return world;
}

absl::StatusOr<Pose> BuildPose(const FlatScene& scene, uint32_t scene_index) {
  if (scene_index >= scene.scenes.size()) {
    return absl::InvalidArgumentError("scene_index: " + std::to_string(scene_index) + "; the scene has " +
                                      std::to_string(scene.scenes.size()));
  }
  std::vector<std::vector<uint32_t>> children(scene.nodes.size());
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
    if (scene.nodes[node].parent >= 0) children[scene.nodes[node].parent].push_back(node);
  }
  // Depth first with a stack of our own: the graph may be as deep as it has nodes.
  struct Visit {
    uint32_t node;
    glm::dmat4 world_from_parent;
  };
  const std::vector<uint32_t>& roots = scene.scenes[scene_index].roots;
  std::vector<Visit> stack;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, glm::dmat4(1)});
  Pose pose;
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const Node& node = scene.nodes[visit.node];
    const glm::dmat4 world_from_node = visit.world_from_parent * node.local;
    for (uint32_t i = 0; i < node.mesh_count; ++i) {
      Instance instance;
      instance.node = visit.node;
      instance.mesh = node.first_mesh + i;
      const Mesh& mesh = scene.meshes[instance.mesh];
      instance.world_from_mesh = glm::translate(world_from_node, mesh.origin);
      for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
        const glm::dvec4 position(scene.positions[mesh.first_vertex + v], 1);
        pose.bounds_ws.Add(glm::dvec3(instance.world_from_mesh * position));
      }
      pose.instances.push_back(instance);
    }
    const std::vector<uint32_t>& below = children[visit.node];
    for (auto child = below.rbegin(); child != below.rend(); ++child) stack.push_back({*child, world_from_node});
  }
  return pose;
}

}  // namespace halfshade
