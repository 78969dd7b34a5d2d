// What moves, bends and multiplies the meshes of a FlatScene (flat_scene.h): plain arrays, valid by construction.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>

namespace halfshade {

// Where an instance of EXT_mesh_gpu_instancing stands in its node.
struct InstancePlace {
  glm::vec3 translation{0};
  glm::quat rotation{1, 0, 0, 0};  // unit
  glm::vec3 scale{1};
};

// What a mesh was before its targets and its joints bend it, and what bends it (deform.h). The mesh is this node's
// alone. Of the vertices of the mesh, in their order, the arrays named below hold a run each.
struct Deformed {
  uint32_t node = 0;
  uint32_t mesh = 0;
  uint32_t first_bind = 0;        // into bind_vertices
  uint32_t first_bind_index = 0;  // into bind_indices: its triangles before degenerate ones are dropped
  uint32_t bind_index_count = 0;  // FlatScene::indices holds as many places from Mesh::first_index on
  uint32_t first_influence = 0;   // into influences
  uint32_t influence_count = 0;   // of each vertex; 0: no skin
  uint32_t first_delta = 0;       // into morph_deltas: [target][vertex]
  uint32_t target_count = 0;      // at most Node::weight_count
};
struct BindVertex {
  glm::vec3 position{0}, normal{0};
  glm::vec4 tangent{0};
};
struct Influence {
  uint32_t joint = 0;  // of the node's skin
  float weight = 0;
};
struct MorphDelta {
  glm::vec3 position{0}, normal{0}, tangent{0};
};
struct Skin {
  uint32_t first_joint = 0;  // into skin_joints and joint_from_mesh
  uint32_t joint_count = 0;
};

enum class AnimatedPath : uint8_t { kTranslation, kRotation, kScale, kWeights };
enum class Interpolation : uint8_t { kStep, kLinear, kCubic };

// One property of one node over time.
struct AnimationChannel {
  uint32_t node = 0;
  AnimatedPath path = AnimatedPath::kTranslation;
  Interpolation interpolation = Interpolation::kLinear;
  uint32_t first_time = 0;  // into animation_times: seconds, increasing
  uint32_t key_count = 0;   // > 0
  // Into animation_values: [key][width], of kCubic [key][in-tangent, value, out-tangent][width].
  uint32_t first_value = 0;
  uint32_t width = 0;  // 3, 4 (x, y, z, w), or the node's weight_count
};
struct Animation {
  std::string name;
  uint32_t first_channel = 0;
  uint32_t channel_count = 0;
  double duration_s = 0;  // the last key of all
};
// What an animated node's local matrix is made of.
struct Rest {
  uint32_t node = 0;
  glm::dvec3 translation{0};
  glm::dquat rotation{1, 0, 0, 0};
  glm::dvec3 scale{1};
};

}  // namespace halfshade
