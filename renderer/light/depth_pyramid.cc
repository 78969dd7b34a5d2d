#include "renderer/light/depth_pyramid.h"

#include <algorithm>
#include <limits>

namespace halfshade {
namespace {

constexpr glm::vec2 kEmptyRange{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};

glm::vec2 Join(const glm::vec2& a, const glm::vec2& b) { return {std::min(a.x, b.x), std::max(a.y, b.y)}; }

}  // namespace

DepthPyramid BuildDepthPyramid(const std::vector<float>& depths, int size) {
  DepthPyramid pyramid;
  int side = (size + DepthPyramid::kBaseTexels - 1) / DepthPyramid::kBaseTexels;
  pyramid.levels.push_back({0, side});
  pyramid.ranges.assign(size_t(side) * side, kEmptyRange);
  for (int y = 0; y < size; ++y) {
    glm::vec2* row = &pyramid.ranges[size_t(y / DepthPyramid::kBaseTexels) * side];
    for (int x = 0; x < size; ++x) {
      const float depth = depths[size_t(y) * size + x];
      glm::vec2& range = row[x / DepthPyramid::kBaseTexels];
      range = Join(range, {depth, depth});
    }
  }
  while (side > 1) {
    const DepthPyramid::Level below = pyramid.levels.back();
    side = (side + 1) / 2;
    const int first = int(pyramid.ranges.size());
    pyramid.levels.push_back({first, side});
    pyramid.ranges.resize(pyramid.ranges.size() + size_t(side) * side, kEmptyRange);
    for (int y = 0; y < below.side; ++y) {
      for (int x = 0; x < below.side; ++x) {
        glm::vec2& range = pyramid.ranges[first + size_t(y / 2) * side + x / 2];
        range = Join(range, pyramid.ranges[below.first + size_t(y) * below.side + x]);
      }
    }
  }
  return pyramid;
}

}  // namespace halfshade
