// Smallest and largest depth of the squares of a depth map.
#pragma once

#include <glm/glm.hpp>
#include <vector>

namespace halfshade {

struct DepthPyramid {
  static constexpr int kBaseTexels = 4;  // a side of a square of level 0; each level doubles it
  struct Level {
    int first = 0;  // into ranges
    int side = 0;   // squares a side
  };
  std::vector<Level> levels;      // the last one is a single square
  std::vector<glm::vec2> ranges;  // smallest, largest; [level][row][column]
};

// `depths`: [size][size], size >= 1. Squares that reach over the map's edge hold what is inside. Pure.
DepthPyramid BuildDepthPyramid(const std::vector<float>& depths, int size);

}  // namespace halfshade
