#include "renderer/scene/pose.h"

#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <unordered_map>

namespace halfshade {
namespace {

// The override of every node that has one.
std::unordered_map<uint32_t, const NodeOverride*> ByNode(const std::vector<NodeOverride>& overrides) {
  std::unordered_map<uint32_t, const NodeOverride*> by_node;
  for (const NodeOverride& change : overrides) by_node[change.node] = &change;
  return by_node;
}

}  // namespace

glm::dmat4 WorldFromNode(const FlatScene& scene, uint32_t node, const std::vector<NodeOverride>& overrides) {
  const auto by_node = ByNode(overrides);
  glm::dmat4 world(1);
  for (int32_t i = int32_t(node); i >= 0; i = scene.nodes[i].parent) {
    const auto change = by_node.find(uint32_t(i));
    const bool is_moved = change != by_node.end() && change->second->local;
    world = (is_moved ? *change->second->local : scene.nodes[i].local) * world;
  }
  return world;
}

absl::StatusOr<Pose> BuildPose(const FlatScene& scene, uint32_t scene_index,
                               const std::vector<NodeOverride>& overrides) {
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
    bool is_visible = true, casts = true, receives = true;  // so far
  };
  const auto by_node = ByNode(overrides);
  const std::vector<uint32_t>& roots = scene.scenes[scene_index].roots;
  std::vector<Visit> stack;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, glm::dmat4(1)});
  Pose pose;
  while (!stack.empty()) {
    Visit visit = stack.back();
    stack.pop_back();
    const Node& node = scene.nodes[visit.node];
    glm::dmat4 local = node.local;
    if (const auto found = by_node.find(visit.node); found != by_node.end()) {
      const NodeOverride& change = *found->second;
      local = change.local.value_or(local);
      visit.is_visible = visit.is_visible && change.is_visible;
      visit.casts = visit.casts && change.casts;
      visit.receives = visit.receives && change.receives;
    }
    const glm::dmat4 world_from_node = visit.world_from_parent * local;
    const bool leaves_a_trace = visit.is_visible || visit.casts;
    for (uint32_t i = 0; leaves_a_trace && i < node.mesh_count; ++i) {
      Instance instance;
      instance.node = visit.node;
      instance.mesh = node.first_mesh + i;
      const Mesh& mesh = scene.meshes[instance.mesh];
      instance.world_from_mesh = glm::translate(world_from_node, mesh.origin);
      instance.is_visible = visit.is_visible;
      instance.casts = visit.casts;
      instance.receives = visit.receives;
      for (uint32_t v = 0; visit.is_visible && v < mesh.vertex_count; ++v) {
        const glm::dvec4 position(scene.positions[mesh.first_vertex + v], 1);
        pose.bounds_ws.Add(glm::dvec3(instance.world_from_mesh * position));
      }
      pose.instances.push_back(instance);
    }
    const std::vector<uint32_t>& below = children[visit.node];
    for (auto child = below.rbegin(); child != below.rend(); ++child) {
      stack.push_back({*child, world_from_node, visit.is_visible, visit.casts, visit.receives});
    }
  }
  return pose;
}

}  // namespace halfshade
