#include "renderer/scene/ray_boxes.h"

#include <algorithm>
#include <utility>

namespace halfshade {
namespace {

uint32_t SpreadBits(uint32_t x) {  // of ten, to every third
  x = (x | (x << 16)) & 0x030000ffu;
  x = (x | (x << 8)) & 0x0300f00fu;
  x = (x | (x << 4)) & 0x030c30c3u;
  return (x | (x << 2)) & 0x09249249u;
}

// Of a point in [-1,1]^3, along a Z curve.
uint32_t PlaceOf(const glm::vec3& point) {
  const glm::uvec3 cell(glm::clamp(point * 512.0f + 512.0f, 0.0f, 1023.0f));
  return SpreadBits(cell.x) | (SpreadBits(cell.y) << 1) | (SpreadBits(cell.z) << 2);
}

}  // namespace

RayBoxes::RayBoxes(const std::vector<glm::vec4>& vertices, const std::vector<uint32_t>& indices) {
  std::vector<std::pair<uint32_t, Box3f>> placed;
  for (size_t first = 0, last = 0; first < indices.size(); first = last) {
    Box3f box;
    uint32_t highest = indices[first];
    for (; last < std::min(first + 3 * kFan, indices.size()); last += 3) {
      if (std::min({indices[last], indices[last + 1], indices[last + 2]}) > highest) break;
      for (size_t i = last; i < last + 3; ++i) {
        highest = std::max(highest, indices[i]);
        box.Add(glm::vec3(vertices[indices[i]]));
      }
    }
    placed.emplace_back(PlaceOf(box.Center()), box);
  }
  if (placed.empty()) return;
  std::stable_sort(placed.begin(), placed.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  levels_.emplace_back();
  for (const auto& [place, box] : placed) levels_.back().push_back(box);
  while (levels_.back().size() > kFan) {
    const std::vector<Box3f>& fine = levels_.back();
    std::vector<Box3f> coarse((fine.size() + kFan - 1) / kFan);
    for (size_t i = 0; i < fine.size(); ++i) {
      coarse[i / kFan].Add(fine[i].min);
      coarse[i / kFan].Add(fine[i].max);
    }
    levels_.push_back(std::move(coarse));
  }
}

uint64_t RayBoxes::SizeBytes() const {
  uint64_t bytes = 0;
  for (const auto& level : levels_) bytes += level.size() * sizeof(Box3f);
  return bytes;
}

}  // namespace halfshade
