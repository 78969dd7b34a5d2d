// Which polygons may stand between some receivers and the light. Included once per instruction set.
#include "renderer/shadow/shaft/bitmask-inl.h"

#if defined(HALFSHADE_SHAFT_QUERY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef HALFSHADE_SHAFT_QUERY_INL_H_
#undef HALFSHADE_SHAFT_QUERY_INL_H_
#else
#define HALFSHADE_SHAFT_QUERY_INL_H_
#endif

#include <cmath>
#include <vector>

#include "renderer/shadow/shaft/polygon_tree.h"

HWY_BEFORE_NAMESPACE();
namespace halfshade {
namespace HWY_NAMESPACE {

// Where some receivers are.
struct Bounds {
  float low[3], high[3];
  float size_m = 0;  // Tile::size_m
};

HWY_INLINE Bounds BoundsOf(const Tile& tile, int first_block, int last_block) {
  Bounds bounds;
  bounds.size_m = tile.size_m;
  const float* const values[3] = {tile.x, tile.y, tile.z};
  for (int axis = 0; axis < 3; ++axis) {
    Floats low = Load(values[axis] + first_block * Tile::kLanes), high = low;
    for (int block = first_block + 1; block < last_block; ++block) {
      const Floats more = Load(values[axis] + block * Tile::kLanes);
      low = Min(low, more);
      high = Max(high, more);
    }
    bounds.low[axis] = Least(low);
    bounds.high[axis] = Greatest(high);
  }
  return bounds;
}

// The hull of a box of receivers and the light: x between low_slope[0] z and 1 + high_slope[0] z, y likewise, within
// the box of both; of receivers that share a plane only what is above it.
struct Shaft {
  float low[2], high[2], z_high;
  float low_slope[2], high_slope[2], slack[2];
  bool has_plane = false;
  float normal[3], offset;
  alignas(64) float a[16], b[16], c[16], d[16];  // planes: a x + b y + c z + d > 0 is outside
};

// Blocks [first, last_plane) share a plane; none where they are none.
HWY_INLINE Shaft MakeShaft(const Tile& tile, int first, int last_plane, const Bounds& bounds) {
  Shaft shaft;
  constexpr float kMostSlope = 1e18f;
  shaft.z_high = bounds.high[2];
  for (int axis = 0; axis < 2; ++axis) {
    const float low = bounds.low[axis], high = bounds.high[axis];
    // What rounding may add to a corner's place beside the shaft's sides.
    shaft.slack[axis] = 1e-6f * (1 + HWY_MAX(std::abs(low), std::abs(high)));
    shaft.low[axis] = HWY_MIN(low, 0.0f) - shaft.slack[axis];
    shaft.high[axis] = HWY_MAX(high, 1.0f) + shaft.slack[axis];
    const float high_slope = (high - 1) / (high > 1 ? bounds.low[2] : bounds.high[2]);
    const float low_slope = low / (low < 0 ? bounds.low[2] : bounds.high[2]);
    shaft.high_slope[axis] = HWY_MIN(high_slope, kMostSlope);
    shaft.low_slope[axis] = HWY_MAX(low_slope, -kMostSlope);
  }
  int planes = 0;
  const auto add = [&](float a, float b, float c, float d) {
    shaft.a[planes] = a;
    shaft.b[planes] = b;
    shaft.c[planes] = c;
    shaft.d[planes++] = d;
  };
  for (int axis = 0; axis < 2; ++axis) {
    const float x = axis == 0 ? 1.0f : 0.0f, y = 1 - x;
    add(x, y, -shaft.high_slope[axis], -1 - shaft.slack[axis]);
    add(-x, -y, shaft.low_slope[axis], -shaft.slack[axis]);
    add(x, y, 0, -shaft.high[axis]);
    add(-x, -y, 0, shaft.low[axis]);
  }
  add(0, 0, 1, -shaft.z_high);
  if (last_plane > first) {
    const int lane = first * Tile::kLanes;
    float least_error = tile.error_m[lane];
    for (int block = first; block < last_plane; ++block) {
      least_error = HWY_MIN(least_error, Least(Load(tile.error_m + block * Tile::kLanes)));
    }
    shaft.has_plane = true;
    shaft.normal[0] = tile.normal_x[lane];
    shaft.normal[1] = tile.normal_y[lane];
    shaft.normal[2] = tile.normal_z[lane];
    // Half of what every lane leaves out; the other half is for the rounding of both questions.
    shaft.offset = tile.offset[lane] + 0.5f * least_error;
    add(-shaft.normal[0], -shaft.normal[1], -shaft.normal[2], shaft.offset);
  }
  while (planes < 16) add(0, 0, 1, -shaft.z_high);
  return shaft;
}

// Bit per box that reaches into the shaft.
HWY_INLINE uint32_t BoxesInside(const Boxes16& boxes, const Shaft& shaft) {
  const Floats low_z = Load(boxes.low[2]), high_z = Min(Load(boxes.high[2]), Set(shaft.z_high));
  Mask inside = low_z < Set(shaft.z_high);
  for (int axis = 0; axis < 2; ++axis) {
    const Floats low = Load(boxes.low[axis]), high = Load(boxes.high[axis]);
    inside = inside & (low <= Set(shaft.high[axis])) & (high >= Set(shaft.low[axis]));
    const Floats& widest_high = shaft.high_slope[axis] > 0 ? high_z : low_z;
    const Floats& widest_low = shaft.low_slope[axis] < 0 ? high_z : low_z;
    inside = inside & (low - Set(shaft.high_slope[axis]) * widest_high <= Set(1 + shaft.slack[axis])) &
             (high - Set(shaft.low_slope[axis]) * widest_low >= Set(-shaft.slack[axis]));
  }
  if (shaft.has_plane) {
    Floats height = Set(-shaft.offset);
    for (int axis = 0; axis < 3; ++axis) {
      height = height + Set(shaft.normal[axis]) * Load(shaft.normal[axis] > 0 ? boxes.high[axis] : boxes.low[axis]);
    }
    inside = inside & (height > Set(0));
  }
  return Bits(inside);
}

// Whether all corners are outside one of the shaft's planes.
HWY_INLINE bool IsOutside(const Polygon& polygon, const Shaft& shaft) {
  const Floats a = Load(shaft.a), b = Load(shaft.b), c = Load(shaft.c), d = Load(shaft.d), zero = Set(0);
  const auto outside = [&](int k) {
    return a * Set(polygon.x[k]) + b * Set(polygon.y[k]) + c * Set(polygon.z[k]) + d > zero;
  };
  Mask all = outside(0) & outside(1) & outside(2);
  if (polygon.corners == 4) all = all & outside(3);
  return Any(all);
}

// Whether every receiver within the bounds sees the front of it.
inline bool ShowsItsFront(const float* normal, float offset, float margin, const Bounds& bounds) {
  float least = -offset;
  for (int axis = 0; axis < 3; ++axis) {
    least += HWY_MIN(normal[axis] * bounds.low[axis], normal[axis] * bounds.high[axis]);
  }
  return least > margin;
}

// Where a level of a dense mesh is drawn: boxes whose distance from the receivers' box is in [near, far).
struct Range {
  float low[3], high[3];  // of the receivers' box, shaft space
  float metres[3];        // of its axes
  float near_m = 0, far_m = 0;
};

// Squared distance between the receivers' box and each of sixteen, and (squared) of their furthest points from it.
HWY_INLINE void MeasureDistances(const Boxes16& boxes, const Range& range, Floats* nearest, Floats* furthest) {
  *nearest = *furthest = Set(0);
  for (int axis = 0; axis < 3; ++axis) {
    const Floats below = Set(range.low[axis]) - Load(boxes.low[axis]);
    const Floats above = Load(boxes.high[axis]) - Set(range.high[axis]);
    const Floats metres = Set(range.metres[axis]);
    const Floats far = Max(Max(below, above), Set(0)) * metres;
    const Floats gap =
        Max(Max(Set(range.low[axis]) - Load(boxes.high[axis]), Load(boxes.low[axis]) - Set(range.high[axis])), Set(0)) *
        metres;
    *nearest = *nearest + gap * gap;
    *furthest = *furthest + far * far;
  }
}

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

// Adds the polygons of one root that may hide the light from receivers within the bounds.
HWY_INLINE void FindPolygons(const PolygonTree& tree, const PolygonTree::Root& root, const Range& range,
                             const Shaft& shaft, const Bounds& bounds, std::vector<uint32_t>* stack,
                             std::vector<uint32_t>* found) {
  const bool has_range = range.near_m > 0 || range.far_m < hwy::HighestValue<float>();
  stack->assign(1, root.node);
  while (!stack->empty()) {
    const PolygonTree::Node& node = tree.nodes[stack->back()];
    stack->pop_back();
    uint32_t inside = BoxesInside(node.boxes, shaft);
    if (has_range && inside != 0) {
      Floats nearest, furthest;
      MeasureDistances(node.boxes, range, &nearest, &furthest);
      inside &= Bits((nearest < Set(range.far_m * range.far_m)) & (furthest >= Set(range.near_m * range.near_m)));
    }
    for (; inside != 0; inside &= inside - 1) {
      const size_t i = hwy::Num0BitsBelowLS1Bit_Nonzero32(inside);
      if (node.count[i] == 0) {
        stack->push_back(node.first[i]);
        continue;
      }
      for (uint32_t p = node.first[i]; p < node.first[i] + node.count[i]; ++p) {
        const Polygon& polygon = tree.polygons[p];
        const float margin = kFourUlps * (polygon.size_m + bounds.size_m);
        if (polygon.is_closed && ShowsItsFront(polygon.normal, polygon.offset, margin, bounds)) continue;
        if (range.near_m > 0 && DistanceOf(polygon, range) < range.near_m) continue;
        if (!IsOutside(polygon, shaft)) found->push_back(p);
      }
    }
  }
}

// Polygons of the tree that may hide the light from receivers within the bounds, each dense mesh at the levels that its
// parts' distances allow: off by `level_error` of the light's smaller edge at most.
HWY_INLINE void FindPolygons(const PolygonTree& tree, const Shaft& shaft, const Bounds& bounds, float level_error,
                             std::vector<uint32_t>* stack, std::vector<uint32_t>* found) {
  found->clear();
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
  // An occluder that is off by e at a distance d shows on the light, at r from the receiver, by e r / d, and more by
  // the slant r / z under which the light is seen: as a fraction of its smaller edge e / d times this.
  const float magnification = farthest / (bounds.low[2] * range.metres[2] * HWY_MIN(range.metres[0], range.metres[1]));
  const float metres_per_error = magnification / level_error;
  for (const PolygonTree::Root& root : tree.roots) {
    range.near_m = root.error_m > 0 ? root.error_m * metres_per_error : 0;
    range.far_m = HWY_MIN(root.next_error_m * metres_per_error + root.next_reach_m, hwy::HighestValue<float>());
    if (range.near_m < hwy::HighestValue<float>()) {
      FindPolygons(tree, root, range, shaft, bounds, stack, found);
    }
  }
}

// The list as arrays.
inline void Arrange(const PolygonTree& tree, const std::vector<uint32_t>& list, const Bounds& tile_bounds,
                    std::vector<Polygons16>* arranged) {
  arranged->resize((list.size() + 15) / 16);
  for (size_t i = 0; i < 16 * arranged->size(); ++i) {
    Polygons16& sixteen = (*arranged)[i / 16];
    const size_t lane = i % 16;
    if (lane == 0) sixteen.closed = 0;
    // Those that fill up are beyond every receiver.
    const bool is_there = i < list.size();
    const Polygon& polygon = tree.polygons[list[is_there ? i : 0]];
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

// Those of a tile's list that may hide the light from one of its blocks.
HWY_INLINE void NarrowList(const PolygonTree& tree, const std::vector<uint32_t>& list,
                           const std::vector<Polygons16>& arranged, const Shaft& shaft, const Bounds& bounds,
                           std::vector<uint32_t>* narrowed) {
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
      const uint32_t p = list[first + hwy::Num0BitsBelowLS1Bit_Nonzero32(inside)];
      if (!IsOutside(tree.polygons[p], shaft)) narrowed->push_back(p);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace halfshade
HWY_AFTER_NAMESPACE();

#endif
