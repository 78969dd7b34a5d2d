#include "renderer/shadow/shaft/box_tree.h"

#include <algorithm>
#include <utility>

namespace halfshade {
namespace {

class TreeBuilder {
 public:
  TreeBuilder(const std::vector<Box3f>& boxes, uint32_t first_item, uint32_t leaf_items, std::vector<TreeNode>* nodes)
      : boxes_(boxes), first_item_(first_item), leaf_items_(leaf_items), nodes_(nodes) {
    order_.reserve(boxes.size());
    for (const Box3f& box : boxes) order_.push_back({box.min + box.max, uint32_t(order_.size())});
  }

  std::vector<uint32_t> Build() {
    const auto root = uint32_t(nodes_->size());
    nodes_->emplace_back();
    BuildNode(root, {0, uint32_t(order_.size())});
    std::vector<uint32_t> order;
    order.reserve(order_.size());
    for (const Entry& entry : order_) order.push_back(entry.box);
    return order;
  }

 private:
  struct Range {
    uint32_t first = 0, last = 0;
    uint32_t size() const { return last - first; }
  };

  struct Entry {
    glm::vec3 center;  // twice
    uint32_t box = 0;
  };

  std::pair<Range, Range> Split(const Range& range) {
    Box3f centers;
    for (uint32_t i = range.first; i < range.last; ++i) centers.Add(order_[i].center);
    const glm::vec3 extent = centers.Extent();
    const int axis = extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
    const uint32_t middle = (range.first + range.last) / 2;
    const auto begin = order_.begin();
    // Ties by number: the same tree wherever the library's selection would put equals.
    std::nth_element(begin + range.first, begin + middle, begin + range.last, [axis](const Entry& a, const Entry& b) {
      const float x = a.center[axis], y = b.center[axis];
      return x < y || (x == y && a.box < b.box);
    });
    return {{range.first, middle}, {middle, range.last}};
  }

  void BuildNode(uint32_t index, const Range& whole) {
    std::vector<Range> groups = {whole};
    while (groups.size() < TreeNode::kWidth) {
      const auto largest = std::max_element(groups.begin(), groups.end(),
                                            [](const Range& a, const Range& b) { return a.size() < b.size(); });
      if (largest->size() <= leaf_items_) break;
      const auto [low, high] = Split(*largest);
      *largest = low;
      groups.push_back(high);
    }
    std::sort(groups.begin(), groups.end(), [](const Range& a, const Range& b) { return a.first < b.first; });
    for (int i = 0; i < TreeNode::kWidth; ++i) {
      Box3f box;
      if (size_t(i) < groups.size()) {
        for (uint32_t k = groups[i].first; k < groups[i].last; ++k) {
          box.Add(boxes_[order_[k].box].min);
          box.Add(boxes_[order_[k].box].max);
        }
      }
      TreeNode& node = (*nodes_)[index];
      constexpr float kMost = std::numeric_limits<float>::max();
      for (int axis = 0; axis < 3; ++axis) {
        node.boxes.low[axis][i] = box.IsEmpty() ? kMost : box.min[axis];
        node.boxes.high[axis][i] = box.IsEmpty() ? -kMost : box.max[axis];
      }
      node.first[i] = 0;
      node.count[i] = 0;
      if (size_t(i) >= groups.size()) continue;
      if (groups[i].size() <= leaf_items_) {
        node.first[i] = first_item_ + groups[i].first;
        node.count[i] = uint8_t(groups[i].size());
        continue;
      }
      node.first[i] = uint32_t(nodes_->size());
      nodes_->emplace_back();
      BuildNode((*nodes_)[index].first[i], groups[i]);
    }
  }

  const std::vector<Box3f>& boxes_;
  const uint32_t first_item_, leaf_items_;
  std::vector<TreeNode>* const nodes_;
  std::vector<Entry> order_;
};

}  // namespace

std::vector<uint32_t> AddTree(const std::vector<Box3f>& boxes, uint32_t first_item, uint32_t leaf_items,
                              std::vector<TreeNode>* nodes) {
  return TreeBuilder(boxes, first_item, leaf_items, nodes).Build();
}

}  // namespace halfshade
