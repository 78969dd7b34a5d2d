// The shaft between some receivers and the light. Included once per instruction set.
#include "renderer/shadow/shaft/bitmask-inl.h"

#if defined(HALFSHADE_SHAFT_SHAFT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef HALFSHADE_SHAFT_SHAFT_INL_H_
#undef HALFSHADE_SHAFT_SHAFT_INL_H_
#else
#define HALFSHADE_SHAFT_SHAFT_INL_H_
#endif

#include <cmath>

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
  static constexpr int kMostPlanes = 10;
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

}  // namespace HWY_NAMESPACE
}  // namespace halfshade
HWY_AFTER_NAMESPACE();

#endif
