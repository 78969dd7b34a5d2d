// glTF's alphaMode BLEND for light: a surface of tiny holes that leaves out 1 - alpha of itself. The twin on the CPU of
// shaders/common/blend.glsl. Pure; any thread.
//
// A point hides light where its alpha is at least its cell's threshold, a hash in (0, 1): alpha 0 never hides, 1 always
// does. Cells are cubes in the mesh's own space, a 4096th of its longest edge, so holes stay on the surface wherever
// it, the light or the camera stand, and every method sees the same ones. Each instance has others: what two surfaces
// let through is the product. A mesh that skins or targets bend has new holes in every pose. Source: Wyman and McGuire
// 2017, "Hashed Alpha Testing". Theirs are cells of a pixel's size; a light has no pixels.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>

#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"

namespace halfshade {

inline constexpr float kBlendCells = 4096;       // along the longest edge of a mesh's box
inline constexpr uint32_t kBlendOffsets = 1024;  // along an axis, for instances

// Mixes all bits of three words (pcg3d of Jarzynski and Olano 2020).
inline glm::uvec3 HashWords(glm::uvec3 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  return v;
}

// Where a point of one instance lies among its cells, in [0, kBlendCells + kBlendOffsets + 1).
class BlendSpace {
 public:
  BlendSpace(const Mesh& mesh, const Instance& instance) {
    const glm::dvec3 extent = mesh.bounds.Extent();
    const double longest = glm::max(extent.x, glm::max(extent.y, extent.z));
    cells_per_unit_ = longest > 0 ? kBlendCells / longest : 0;
    // Faces of boxes, and planes at simple fractions of them, must not lie where two cells meet.
    constexpr double kWithinCell = 0.37;
    const glm::uvec3 offset = HashWords({instance.node, instance.mesh, instance.place}) % kBlendOffsets;
    first_ = glm::dvec3(offset) + kWithinCell - glm::dvec3(mesh.bounds.min) * cells_per_unit_;
  }
  glm::vec3 Place(const glm::vec3& position) const { return glm::dvec3(position) * cells_per_unit_ + first_; }

 private:
  double cells_per_unit_ = 0;
  glm::dvec3 first_{0};
};

// Whether light meets BLEND whose alpha is to be tested.
inline bool HasBlendCaster(const FlatScene& scene, const Pose& pose) {
  return std::any_of(pose.instances.begin(), pose.instances.end(), [&](const Instance& instance) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    return instance.casts && scene.materials[mesh.material].alpha_mode == AlphaMode::kBlend &&
           scene.CoverageOf(mesh) == MaskCoverage::kTested;
  });
}

// Of the cell of a place; a place that is no number is in some cell.
inline float BlendThreshold(const glm::vec3& place) {
  glm::uvec3 cell;
  for (int i = 0; i < 3; ++i) cell[i] = uint32_t(std::min(std::max(0.0f, place[i]), 2 * kBlendCells));
  return (float(HashWords(cell).x >> 9u) + 0.5f) * 0x1p-23f;
}

}  // namespace halfshade
