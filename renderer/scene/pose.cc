#include "renderer/scene/pose.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <unordered_map>

#include "renderer/status.h"

namespace halfshade {
namespace {

// The override of every node that has one.
std::unordered_map<uint32_t, const NodeOverride*> ByNode(const std::vector<NodeOverride>& overrides) {
  std::unordered_map<uint32_t, const NodeOverride*> by_node;
  for (const NodeOverride& change : overrides) by_node[change.node] = &change;
  return by_node;
}

// Of the vertices of what is drawn. The corners of the mesh's box tell whether any of them could be outside.
void AddBounds(const FlatScene& scene, const Mesh& mesh, const glm::dmat4& world_from_mesh, const Box3d& corners,
               Box3d* bounds_ws) {
  // Beyond what rounding could move a vertex out of its box.
  const glm::dvec3 slack = 1e-12 * (glm::abs(corners.min) + glm::abs(corners.max));
  const bool is_inside = !bounds_ws->IsEmpty() && glm::all(glm::greaterThan(corners.min - slack, bounds_ws->min)) &&
                         glm::all(glm::lessThan(corners.max + slack, bounds_ws->max));
  for (uint32_t v = 0; !is_inside && v < mesh.vertex_count; ++v) {
    const glm::dvec4 position(scene.positions[mesh.first_vertex + v], 1);
    bounds_ws->Add(glm::dvec3(world_from_mesh * position));
  }
}

// The node's meshes at each of its places; `instance` has what they share.
absl::Status AddInstances(const FlatScene& scene, const Node& node, const glm::dmat4& world_from_node,
                          Instance instance, Pose* pose) {
  for (uint32_t p = 0; p < std::max(1u, node.place_count); ++p) {
    const glm::dmat4 world_from_place = WorldFromPlace(scene, node, p, world_from_node);
    for (uint32_t m = node.first_mesh; m < node.first_mesh + node.mesh_count; ++m) {
      const Mesh& mesh = scene.meshes[m];
      if (mesh.index_count == 0) continue;
      instance.mesh = m;
      instance.place = p;
      instance.world_from_mesh = glm::translate(world_from_place, mesh.origin);
      const std::optional<Box3d> corners = BoxInWorld(mesh, instance.world_from_mesh);
      if (!corners) {
        return absl::InvalidArgumentError("/nodes/" + std::to_string(instance.node) +
                                          ": its mesh reaches over 1e18 m away");
      }
      if (instance.is_visible) AddBounds(scene, mesh, instance.world_from_mesh, *corners, &pose->bounds_ws);
      pose->instances.push_back(instance);
    }
  }
  return absl::OkStatus();
}

}  // namespace

std::optional<Box3d> BoxInWorld(const Mesh& mesh, const glm::dmat4& world_from_mesh) {
  Box3d corners;
  for (int corner = 0; corner < 8; ++corner) {
    glm::dvec4 position(0, 0, 0, 1);
    for (int i = 0; i < 3; ++i) position[i] = corner >> i & 1 ? mesh.bounds.max[i] : mesh.bounds.min[i];
    const glm::dvec3 world(world_from_mesh * position);
    for (int i = 0; i < 3; ++i) {
      if (!(std::abs(world[i]) <= kMaxCoordinateM)) return std::nullopt;
    }
    corners.Add(world);
  }
  return corners;
}

glm::dmat4 WorldFromPlace(const FlatScene& scene, const Node& node, uint32_t index, const glm::dmat4& world_from_node) {
  if (node.place_count == 0) return world_from_node;
  const InstancePlace& place = scene.places[node.first_place + index];
  return glm::scale(
      glm::translate(world_from_node, glm::dvec3(place.translation)) * glm::mat4_cast(glm::dquat(place.rotation)),
      glm::dvec3(place.scale));
}

std::vector<glm::dmat4> WorldFromNodes(const FlatScene& scene, const std::vector<NodeOverride>& overrides) {
  std::vector<glm::dmat4> world(scene.nodes.size());
  std::vector<bool> is_done(scene.nodes.size(), false);
  for (uint32_t i = 0; i < scene.nodes.size(); ++i) world[i] = scene.nodes[i].local;
  for (const NodeOverride& change : overrides) {
    if (change.local) world[change.node] = *change.local;
  }
  std::vector<uint32_t> path;
  for (uint32_t i = 0; i < scene.nodes.size(); ++i) {
    for (int32_t at = int32_t(i); at >= 0 && !is_done[size_t(at)]; at = scene.nodes[size_t(at)].parent) {
      path.push_back(uint32_t(at));
    }
    for (; !path.empty(); path.pop_back()) {
      const uint32_t node = path.back();
      const int32_t parent = scene.nodes[node].parent;
      if (parent >= 0) world[node] = world[size_t(parent)] * world[node];
      is_done[node] = true;
    }
  }
  return world;
}

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
    if (visit.is_visible || visit.casts) {
      Instance instance;
      instance.node = visit.node;
      instance.is_visible = visit.is_visible;
      instance.casts = visit.casts;
      instance.receives = visit.receives;
      RETURN_IF_ERROR(AddInstances(scene, node, node.skin >= 0 ? glm::dmat4(1) : world_from_node, instance, &pose));
    }
    const std::vector<uint32_t>& below = children[visit.node];
    for (auto child = below.rbegin(); child != below.rend(); ++child) {
      stack.push_back({*child, world_from_node, visit.is_visible, visit.casts, visit.receives});
    }
  }
  return pose;
}

}  // namespace halfshade
