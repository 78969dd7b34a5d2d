// Which polygons may stand between some receivers and the light. Included once per instruction set.
#include "renderer/shadow/shaft/placed_polygons-inl.h"

#if defined(HALFSHADE_SHAFT_QUERY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef HALFSHADE_SHAFT_QUERY_INL_H_
#undef HALFSHADE_SHAFT_QUERY_INL_H_
#else
#define HALFSHADE_SHAFT_QUERY_INL_H_
#endif

#include <cmath>
#include <vector>

#include "renderer/shadow/shaft/polygon_tree.h"
#include "renderer/shadow/shaft/resolve_tile.h"

HWY_BEFORE_NAMESPACE();
namespace halfshade {
namespace HWY_NAMESPACE {

inline float DistanceOf(const Polygon& polygon, const Range& range) {
  const float* const corners[3] = {polygon.x, polygon.y, polygon.z};
  float sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float* p = corners[axis];
    const float low = HWY_MIN(HWY_MIN(p[0], p[1]), HWY_MIN(p[2], p[3]));
    const float high = HWY_MAX(HWY_MAX(p[0], p[1]), HWY_MAX(p[2], p[3]));
    const float gap = HWY_MAX(HWY_MAX(range.low[axis] - high, low - range.high[axis]), 0.0f) * range.metres[axis];
    sum += gap * gap;
  }
  return std::sqrt(sum);
}

// What one question asks of a tree.
struct Question {
  const Shaft& shaft;
  const Bounds& bounds;
  float metres_per_error;
  std::vector<uint32_t>* stack;
};

// visit(first, count) for the items of each leaf that reaches into the shaft and the range. `instance`: null where
// boxes are in shaft space.
template <typename Visit>
HWY_INLINE void WalkTree(const std::vector<TreeNode>& nodes, uint32_t root, const ShapeInstance* instance,
                         const Range& range, const Question& question, const Visit& visit) {
  std::vector<uint32_t>& stack = *question.stack;
  stack.assign(1, root);
  Boxes16 placed;
  while (!stack.empty()) {
    const TreeNode& node = nodes[stack.back()];
    stack.pop_back();
    if (instance != nullptr) PlaceBoxes(node.boxes, *instance, &placed);
    const Boxes16& boxes = instance != nullptr ? placed : node.boxes;
    uint32_t inside = BoxesInside(boxes, question.shaft);
    if (inside != 0 && range.IsBounded()) inside &= BoxesWithin(boxes, range);
    for (; inside != 0; inside &= inside - 1) {
      const size_t i = hwy::Num0BitsBelowLS1Bit_Nonzero32(inside);
      if (node.count[i] == 0) {
        stack.push_back(node.first[i]);
        continue;
      }
      visit(node.first[i], node.count[i]);
    }
  }
}

// Whether it may hide the light from receivers within the bounds.
HWY_INLINE bool MayHide(const Polygon& polygon, const Range& range, const Question& question) {
  const float margin = kFourUlps * (polygon.size_m + question.bounds.size_m);
  if (polygon.is_closed && ShowsItsFront(polygon.normal, polygon.offset, margin, question.bounds)) return false;
  if (range.near_m > 0 && DistanceOf(polygon, range) < range.near_m) return false;
  return !IsOutside(polygon, question.shaft);
}

// Calls draw(root, range) for each level of a mesh that the range has room for. Lengths of the roots in metres: errors
// times `scale`, reaches times `stretch`.
template <typename Draw>
HWY_INLINE void ForLevels(const std::vector<TreeRoot>& roots, float scale, float stretch, const Question& question,
                          Range range, const Draw& draw) {
  for (const TreeRoot& root : roots) {
    range.near_m = root.error > 0 ? root.error * scale * question.metres_per_error : 0;
    range.far_m = HWY_MIN(root.next_error * scale * question.metres_per_error + root.next_reach * stretch,
                          hwy::HighestValue<float>());
    if (range.near_m < hwy::HighestValue<float>()) draw(root, range);
  }
}

// Polygons of the tree that may hide the light from receivers within the bounds, each dense mesh at the levels that its
// parts' distances allow: off by `level_error` of the light's smaller edge at most.
HWY_INLINE void FindPolygons(const PolygonTree& tree, const Shaft& shaft, const Bounds& bounds, float level_error,
                             TileScratch* scratch) {
  scratch->tile.clear();
  Range range;
  float farthest = 0;  // from the light's middle, metres, squared
  for (int axis = 0; axis < 3; ++axis) {
    range.low[axis] = bounds.low[axis];
    range.high[axis] = bounds.high[axis];
    range.metres[axis] = float(1 / tree.space.scale[axis]);
    const float middle = axis == 2 ? 0 : 0.5f;
    const float reach = HWY_MAX(std::abs(bounds.low[axis] - middle), std::abs(bounds.high[axis] - middle));
    farthest += reach * range.metres[axis] * reach * range.metres[axis];
  }
  range.far_m = hwy::HighestValue<float>();
  // An occluder that is off by e at a distance d shows on the light, at r from the receiver, by e r / d, and more by
  // the slant r / z under which the light is seen: as a fraction of its smaller edge e / d times this.
  const float magnification = farthest / (bounds.low[2] * range.metres[2] * HWY_MIN(range.metres[0], range.metres[1]));
  const Question question = {shaft, bounds, magnification / level_error, &scratch->stack};
  const auto add = [&](const Polygon& polygon, const Range& here) {
    if (MayHide(polygon, here, question)) scratch->tile.push_back(polygon);
  };
  if (!tree.polygons.empty()) {
    WalkTree(tree.nodes, tree.polygon_root, nullptr, range, question, [&](uint32_t first, uint32_t count) {
      for (uint32_t item = first; item < first + count; ++item) add(tree.polygons[item], range);
    });
  }
  if (tree.instances.empty()) return;
  scratch->instances.clear();
  PlacedPolygons placed;
  WalkTree(tree.nodes, tree.instance_root, nullptr, range, question, [&](uint32_t first, uint32_t count) {
    for (uint32_t item = first; item < first + count; ++item) scratch->instances.push_back(item);
  });
  for (const uint32_t index : scratch->instances) {
    const ShapeInstance& instance = tree.instances[index];
    const MeshShape& shape = *instance.shape;
    const auto draw = [&](const TreeRoot& root, const Range& here) {
      WalkTree(shape.nodes, root.node, &instance, here, question, [&](uint32_t first, uint32_t) {
        const Faces16& faces = shape.faces[first / 16];
        uint32_t inside = FacesInside(faces, instance, shaft, bounds, here);
        if (inside == 0) return;
        if (!instance.is_cut) {
          PlacePolygons(faces, instance, tree.space, &placed);
          inside &= ~placed.flat;
        }
        for (; inside != 0; inside &= inside - 1) {
          const auto lane = uint32_t(hwy::Num0BitsBelowLS1Bit_Nonzero32(inside));
          if (!instance.is_cut) {
            add(placed.At(lane), here);
            continue;
          }
          const PolygonParts parts = MakePolygons(instance, faces.At(lane), tree.space);
          for (int part = 0; part < parts.count; ++part) add(parts.polygons[part], here);
        }
      });
    };
    ForLevels(shape.roots, instance.scale, instance.stretch, question, range, draw);
  }
}

// The list as arrays.
inline void Arrange(const std::vector<Polygon>& list, const Bounds& tile_bounds, std::vector<Polygons16>* arranged) {
  arranged->resize((list.size() + 15) / 16);
  for (size_t i = 0; i < 16 * arranged->size(); ++i) {
    Polygons16& sixteen = (*arranged)[i / 16];
    const size_t lane = i % 16;
    if (lane == 0) sixteen.closed = 0;
    // Those that fill up are beyond every receiver.
    const bool is_there = i < list.size();
    const Polygon& polygon = list[is_there ? i : 0];
    const float* const corners[3] = {polygon.x, polygon.y, polygon.z};
    for (int axis = 0; axis < 3; ++axis) {
      const float* p = corners[axis];
      sixteen.boxes.low[axis][lane] = HWY_MIN(HWY_MIN(p[0], p[1]), HWY_MIN(p[2], p[3]));
      sixteen.boxes.high[axis][lane] = HWY_MAX(HWY_MAX(p[0], p[1]), HWY_MAX(p[2], p[3]));
      sixteen.normal[axis][lane] = polygon.normal[axis];
    }
    if (!is_there) sixteen.boxes.low[2][lane] = hwy::HighestValue<float>();
    sixteen.offset[lane] = polygon.offset;
    sixteen.margin[lane] = kFourUlps * (polygon.size_m + tile_bounds.size_m);
    sixteen.closed |= uint32_t(polygon.is_closed) << lane;
  }
}

// Places of those of a tile's list that may hide the light from one of its blocks.
HWY_INLINE void NarrowList(const std::vector<Polygon>& list, const std::vector<Polygons16>& arranged,
                           const Shaft& shaft, const Bounds& bounds, std::vector<uint32_t>* narrowed) {
  narrowed->clear();
  for (size_t first = 0; first < list.size(); first += 16) {
    const Polygons16& sixteen = arranged[first / 16];
    uint32_t inside = BoxesInside(sixteen.boxes, shaft);
    if ((inside & sixteen.closed) != 0) {
      Floats least = Set(0) - Load(sixteen.offset);
      for (int axis = 0; axis < 3; ++axis) {
        const Floats normal = Load(sixteen.normal[axis]);
        least = least + Min(normal * Set(bounds.low[axis]), normal * Set(bounds.high[axis]));
      }
      inside &= ~(sixteen.closed & Bits(least > Load(sixteen.margin)));
    }
    for (; inside != 0; inside &= inside - 1) {
      const auto place = uint32_t(first + hwy::Num0BitsBelowLS1Bit_Nonzero32(inside));
      if (!IsOutside(list[place], shaft)) narrowed->push_back(place);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace halfshade
HWY_AFTER_NAMESPACE();

#endif
