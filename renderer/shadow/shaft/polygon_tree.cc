#include "renderer/shadow/shaft/polygon_tree.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "renderer/scene/flat_scene.h"

namespace halfshade {
namespace {

class TreeBuilder {
 public:
  explicit TreeBuilder(const std::vector<Polygon>& polygons) : polygons_(polygons) {
    boxes_.reserve(polygons.size());
    order_.reserve(polygons.size());
    for (const Polygon& polygon : polygons) {
      Box3f box;
      for (int k = 0; k < polygon.corners; ++k) box.Add({polygon.x[k], polygon.y[k], polygon.z[k]});
      order_.push_back({box.min + box.max, uint32_t(boxes_.size())});
      boxes_.push_back(box);
    }
  }

  // Adds them behind what the tree has.
  void Build(PolygonTree* tree) {
    first_ = uint32_t(tree->polygons.size());
    const auto root = uint32_t(tree->nodes.size());
    tree->nodes.emplace_back();
    BuildNode(root, {0, uint32_t(order_.size())}, &tree->nodes);
    for (const Entry& entry : order_) tree->polygons.push_back(polygons_[entry.polygon]);
  }

  float LongestDiagonal(const glm::vec3& metres) const {
    float longest = 0;
    for (const Box3f& box : boxes_) longest = std::max(longest, glm::length(box.Extent() * metres));
    return longest;
  }

 private:
  struct Range {
    uint32_t first = 0, last = 0;
    uint32_t size() const { return last - first; }
  };

  struct Entry {
    glm::vec3 center;  // twice
    uint32_t polygon = 0;
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
      return x < y || (x == y && a.polygon < b.polygon);
    });
    return {{range.first, middle}, {middle, range.last}};
  }

  void BuildNode(uint32_t index, const Range& whole, std::vector<PolygonTree::Node>* nodes) {
    std::vector<Range> groups = {whole};
    while (groups.size() < PolygonTree::kWidth) {
      const auto largest = std::max_element(groups.begin(), groups.end(),
                                            [](const Range& a, const Range& b) { return a.size() < b.size(); });
      if (largest->size() <= PolygonTree::kLeafPolygons) break;
      const auto [low, high] = Split(*largest);
      *largest = low;
      groups.push_back(high);
    }
    std::sort(groups.begin(), groups.end(), [](const Range& a, const Range& b) { return a.first < b.first; });
    for (int i = 0; i < PolygonTree::kWidth; ++i) {
      Box3f box;
      if (size_t(i) < groups.size()) {
        for (uint32_t k = groups[i].first; k < groups[i].last; ++k) {
          box.Add(boxes_[order_[k].polygon].min);
          box.Add(boxes_[order_[k].polygon].max);
        }
      }
      PolygonTree::Node& node = (*nodes)[index];
      constexpr float kMost = std::numeric_limits<float>::max();
      for (int axis = 0; axis < 3; ++axis) {
        node.boxes.low[axis][i] = box.IsEmpty() ? kMost : box.min[axis];
        node.boxes.high[axis][i] = box.IsEmpty() ? -kMost : box.max[axis];
      }
      node.first[i] = 0;
      node.count[i] = 0;
      if (size_t(i) >= groups.size()) continue;
      if (groups[i].size() <= PolygonTree::kLeafPolygons) {
        node.first[i] = first_ + groups[i].first;
        node.count[i] = uint8_t(groups[i].size());
        continue;
      }
      node.first[i] = uint32_t(nodes->size());
      nodes->emplace_back();
      BuildNode((*nodes)[index].first[i], groups[i], nodes);
    }
  }

  const std::vector<Polygon>& polygons_;
  uint32_t first_ = 0;  // place of the first of them in the tree
  std::vector<Entry> order_;
  std::vector<Box3f> boxes_;
};

}  // namespace

PolygonTree BuildPolygonTree(ShaftPolygons polygons) {
  PolygonTree tree;
  tree.space = polygons.space;
  size_t count = polygons.polygons.size();
  for (const PolygonLevel& level : polygons.levels) count += level.polygons.size();
  tree.polygons.reserve(count);
  tree.nodes.reserve(count / 16 + 16 * (polygons.levels.size() + 1));
  const glm::vec3 metres(1.0 / polygons.space.scale);
  const auto add = [&](const std::vector<Polygon>& part, float error_m, float next_error_m) {
    if (part.empty()) return;
    TreeBuilder builder(part);
    // Of the level before it this is the next.
    if (error_m > 0 && !tree.roots.empty()) tree.roots.back().next_reach_m = builder.LongestDiagonal(metres);
    tree.roots.push_back({.node = uint32_t(tree.nodes.size()), .error_m = error_m, .next_error_m = next_error_m});
    builder.Build(&tree);
  };
  add(polygons.polygons, 0, std::numeric_limits<float>::infinity());
  for (const PolygonLevel& level : polygons.levels) add(level.polygons, level.error_m, level.next_error_m);
  tree.masked = std::move(polygons.masked);
  return tree;
}

}  // namespace halfshade
