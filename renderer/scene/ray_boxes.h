// A tree of boxes around the casting triangles of a RayScene: whether a convex shape holds none of them.
//
// Trace space (ray_scene.h). Immutable once made; any number of threads may ask. Up to eight triangles that follow each
// other with vertices in common (or between those of the others) share a box: a ground's and a chair's never do. Boxes
// are in the order of a Z curve, eight of them share the next, and so on.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/flat_scene.h"

namespace halfshade {

class RayBoxes {
 public:
  RayBoxes() = default;
  // Three indices a triangle into `vertices`, all finite.
  RayBoxes(const std::vector<glm::vec4>& vertices, const std::vector<uint32_t>& indices);

  // Whether every triangle is in a box of which `is_outside` holds. Requires that it holds of every part of a box that
  // it holds of.
  template <typename Predicate>
  bool AreAllOutside(const Predicate& is_outside) const {
    return levels_.empty() || AreOutside(levels_.size() - 1, 0, levels_.back().size(), is_outside);
  }
  uint64_t SizeBytes() const;

 private:
  static constexpr size_t kFan = 8;

  template <typename Predicate>
  bool AreOutside(size_t level, size_t first, size_t last, const Predicate& is_outside) const {
    for (size_t i = first; i < last; ++i) {
      if (is_outside(levels_[level][i])) continue;
      if (level == 0) return false;
      if (!AreOutside(level - 1, kFan * i, std::min(kFan * (i + 1), levels_[level - 1].size()), is_outside)) {
        return false;
      }
    }
    return true;
  }

  std::vector<std::vector<Box3f>> levels_;  // finest first
};

}  // namespace halfshade
