// Where everything stands for one request: node transforms multiplied out. Pure; no GL.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

// Metres from the origin that a vertex may have, in its mesh and in the world: float still holds the square.
inline constexpr double kMaxCoordinateM = 1e18;

// One mesh at one place.
struct Instance {
  uint32_t node = 0;
  uint32_t mesh = 0;
  glm::dmat4 world_from_mesh{1};  // takes Mesh-relative positions (the mesh's origin is folded in)
  uint32_t place = 0;             // of the node's
  bool is_visible = true;         // drawn for the camera
  bool casts = true;              // whether drawn or not
  bool receives = true;
};

struct Pose {
  std::vector<Instance> instances;  // those that are drawn or cast
  Box3d bounds_ws;                  // of the vertices of what is drawn (exact), empty if that is nothing
};

// The pose of one glTF scene: skinned meshes as they are (deform.h bends them, and has put them into world space), a
// node's instances one after another; with changes (RenderRequest::node_overrides) to nodes in range, each to another
// one. INVALID_ARGUMENT when scene_index is out of range ("scene_index: 3; the scene has 1"), and where the changes
// take a mesh over kMaxCoordinateM away, naming its node.
absl::StatusOr<Pose> BuildPose(const FlatScene& scene, uint32_t scene_index,
                               const std::vector<NodeOverride>& overrides = {});

// Around a mesh's box where it stands; none where that is over kMaxCoordinateM away, or not finite.
std::optional<Box3d> BoxInWorld(const Mesh& mesh, const glm::dmat4& world_from_mesh);

// World transforms of all nodes.
std::vector<glm::dmat4> WorldFromNodes(const FlatScene& scene, const std::vector<NodeOverride>& overrides = {});

// Where a node's meshes stand at its place `index`; at the node itself where it has no places.
glm::dmat4 WorldFromPlace(const FlatScene& scene, const Node& node, uint32_t index, const glm::dmat4& world_from_node);

// World transform of a node: the product of its ancestors' local matrices and its own.
glm::dmat4 WorldFromNode(const FlatScene& scene, uint32_t node, const std::vector<NodeOverride>& overrides = {});

}  // namespace halfshade
