// Polygons in a bounding volume hierarchy of sixteen children a node, for questions that a shaft asks of sixteen boxes
// at a time. Immutable once built. No GL.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "renderer/shadow/shaft/polygons.h"

namespace halfshade {

// Sixteen boxes in shaft space, as arrays. An unused one is empty: low > high.
struct alignas(64) Boxes16 {
  float low[3][16], high[3][16];
};

// Sixteen polygons of a list, as arrays.
struct alignas(64) Polygons16 {
  Boxes16 boxes;
  float normal[3][16], offset[16], margin[16];
  uint32_t closed = 0;  // bit per polygon
};

struct PolygonTree {
  static constexpr int kWidth = 16;
  static constexpr uint32_t kLeafPolygons = 8;  // at most
  struct Node {
    Boxes16 boxes;
    uint32_t first[kWidth];  // a node, or the first polygon of a leaf
    uint8_t count[kWidth];   // polygons of a leaf; 0: a node
  };
  // What has no levels, or one level of a dense mesh (PolygonLevel).
  struct Root {
    uint32_t node = 0;
    float error_m = 0;
    float next_error_m = std::numeric_limits<float>::infinity();
    float next_reach_m = 0;  // longest diagonal of the boxes of the next level's polygons
  };
  std::vector<Root> roots;  // none where nothing hides the light
  std::vector<Node> nodes;
  std::vector<Polygon> polygons;
  std::vector<MaskedTriangle> masked;
  ShaftSpace space;
  uint64_t SizeBytes() const {
    return roots.size() * sizeof(Root) + nodes.size() * sizeof(Node) + polygons.size() * sizeof(Polygon) +
           masked.size() * sizeof(MaskedTriangle);
  }
};

// Split at the median of the longest axis of the centres, whichever group is largest, until a node is full.
PolygonTree BuildPolygonTree(ShaftPolygons polygons);

}  // namespace halfshade
