// A bounding volume hierarchy of sixteen children a node, over boxes of whatever stands in them, for questions that a
// shaft asks of sixteen boxes at a time. No GL.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "renderer/scene/flat_scene.h"

namespace halfshade {

// Sixteen boxes, as arrays. An unused one is empty: low > high.
struct alignas(64) Boxes16 {
  float low[3][16], high[3][16];
};

struct TreeNode {
  static constexpr int kWidth = 16;
  Boxes16 boxes;
  uint32_t first[kWidth];  // a node, or the first item of a leaf
  uint8_t count[kWidth];   // items of a leaf; 0: a node
};

// The tree of one level of a dense mesh, in a list of nodes. From a receiver at a distance d (both boxes') its items
// count where d is `error` times some factor of the receiver's or more, and the next level's do not yet
// (renderer/shadow/shaft/README).
struct TreeRoot {
  uint32_t node = 0;
  float error = 0;                                            // of the surface; 0: the mesh itself
  float next_error = std::numeric_limits<float>::infinity();  // of the next level; infinite: there is none
  float next_reach = 0;                                       // longest diagonal of the boxes of the next level's items
};

// Adds a tree over the boxes to the nodes, its root first, with at most `leaf_items` in a leaf, and says in which order
// its leaves name them: item first_item + i is box order[i]. Split at the median of the longest axis of the centres,
// whichever group is largest, until a node is full.
std::vector<uint32_t> AddTree(const std::vector<Box3f>& boxes, uint32_t first_item, uint32_t leaf_items,
                              std::vector<TreeNode>* nodes);

}  // namespace halfshade
