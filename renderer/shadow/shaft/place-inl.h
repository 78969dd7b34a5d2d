// Boxes and faces of a mesh where an instance has them, sixteen at a time. Included once per instruction set.
#include "renderer/shadow/shaft/range-inl.h"

#if defined(HALFSHADE_SHAFT_PLACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef HALFSHADE_SHAFT_PLACE_INL_H_
#undef HALFSHADE_SHAFT_PLACE_INL_H_
#else
#define HALFSHADE_SHAFT_PLACE_INL_H_
#endif

#include <cmath>

#include "renderer/shadow/shaft/mesh_shape.h"

HWY_BEFORE_NAMESPACE();
namespace halfshade {
namespace HWY_NAMESPACE {

// In shaft space, no smaller than they are.
HWY_INLINE void PlaceBoxes(const Boxes16& boxes, const ShapeInstance& instance, Boxes16* placed) {
  Floats center[3], half[3];
  for (int axis = 0; axis < 3; ++axis) {
    const Floats low = Load(boxes.low[axis]) * Set(0.5f), high = Load(boxes.high[axis]) * Set(0.5f);
    center[axis] = high + low;
    half[axis] = high - low;
  }
  for (int row = 0; row < 3; ++row) {
    Floats middle = Set(instance.origin[row]), reach = Set(instance.slack[row]);
    for (int column = 0; column < 3; ++column) {
      const float axis = instance.axes[column][row];
      middle = middle + Set(axis) * center[column];
      reach = reach + Set(std::abs(axis)) * half[column];
    }
    Store(middle - reach, placed->low[row]);
    Store(middle + reach, placed->high[row]);
  }
}

// Sixteen faces in shaft space, each coordinate off by ShapeInstance::slack at most.
struct PlacedFaces {
  Floats corners[4][3];
};

HWY_INLINE PlacedFaces PlaceFaces(const Faces16& faces, const ShapeInstance& instance) {
  PlacedFaces placed;
  for (int k = 0; k < 4; ++k) {
    for (int row = 0; row < 3; ++row) {
      Floats& coordinate = placed.corners[k][row] = Set(instance.origin[row]);
      for (int column = 0; column < 3; ++column) {
        coordinate = coordinate + Set(instance.axes[column][row]) * Load(faces.corners[k][column]);
      }
    }
  }
  return placed;
}

// Bit per face whose corners are all, slack and all, outside one of the shaft's planes.
HWY_INLINE uint32_t FacesOutside(const PlacedFaces& faces, const float* slack, const Shaft& shaft) {
  uint32_t outside = 0;
  for (int plane = 0; plane < Shaft::kMostPlanes; ++plane) {
    const float a = shaft.a[plane], b = shaft.b[plane], c = shaft.c[plane], d = shaft.d[plane];
    const float more =
        std::abs(a) * slack[0] + std::abs(b) * slack[1] + std::abs(c) * slack[2] + kFourUlps * std::abs(d);
    const Floats least = Set(more - d);
    Mask all = LanesOf(0xffff);
    for (const Floats(&p)[3] : faces.corners) all = all & (Set(a) * p[0] + Set(b) * p[1] + Set(c) * p[2] > least);
    outside |= Bits(all);
  }
  return outside;
}

// Whether every receiver within the bounds is on the side that the face's corners run around to the left: surely so,
// whatever the slack.
HWY_INLINE Mask ShowTheirFronts(const PlacedFaces& faces, const float* slack, const Mask& turned,
                                const Bounds& bounds) {
  Floats arm[3][3], reach[3];
  for (int axis = 0; axis < 3; ++axis) {
    reach[axis] = Set(0);
    for (int k = 0; k < 3; ++k) {
      arm[k][axis] = faces.corners[k + 1][axis] - faces.corners[0][axis];
      reach[axis] = reach[axis] + Abs(arm[k][axis]);
    }
  }
  Floats height = Set(0), error = Set(0);
  for (int x = 0; x < 3; ++x) {
    const int y = (x + 1) % 3, z = (x + 2) % 3;
    // Of both halves of a quad.
    const Floats normal =
        arm[0][y] * arm[1][z] - arm[0][z] * arm[1][y] + (arm[1][y] * arm[2][z] - arm[1][z] * arm[2][y]);
    const Floats outward = Select(turned, Set(0) - normal, normal);
    const Floats low = Set(bounds.low[x]) - faces.corners[0][x], high = Set(bounds.high[x]) - faces.corners[0][x];
    height = height + Min(outward * low, outward * high);
    // An arm is off by two slacks; the normal by four times the product's sums at most.
    const Floats normal_error = Set(4 * slack[y]) * reach[z] + Set(4 * slack[z]) * reach[y];
    error = error + normal_error * Max(Abs(low), Abs(high)) + Abs(normal) * Set(2 * slack[x]);
  }
  return height > error;
}

// Around each, no smaller.
HWY_INLINE void BoxFaces(const PlacedFaces& faces, const float* slack, Boxes16* boxes) {
  const Floats(&p)[4][3] = faces.corners;
  for (int axis = 0; axis < 3; ++axis) {
    const Floats low = Min(Min(p[0][axis], p[1][axis]), Min(p[2][axis], p[3][axis]));
    const Floats high = Max(Max(p[0][axis], p[1][axis]), Max(p[2][axis], p[3][axis]));
    Store(low - Set(slack[axis]), boxes->low[axis]);
    Store(high + Set(slack[axis]), boxes->high[axis]);
  }
}

// Bit per face that may hide the light from receivers within the bounds.
HWY_INLINE uint32_t FacesInside(const Faces16& faces, const ShapeInstance& instance, const Shaft& shaft,
                                const Bounds& bounds, const Range& range) {
  const PlacedFaces placed = PlaceFaces(faces, instance);
  uint32_t inside = faces.used & ~FacesOutside(placed, instance.slack, shaft);
  if (inside != 0 && range.IsBounded()) {
    Boxes16 boxes;
    BoxFaces(placed, instance.slack, &boxes);
    inside &= BoxesWithin(boxes, range);
  }
  if (!instance.is_cut && (inside & faces.closed) != 0) {
    const Mask turned = LanesOf(instance.is_mirrored ? ~faces.turned & 0xffff : faces.turned);
    inside &= ~(faces.closed & Bits(ShowTheirFronts(placed, instance.slack, turned, bounds)));
  }
  return inside;
}

}  // namespace HWY_NAMESPACE
}  // namespace halfshade
HWY_AFTER_NAMESPACE();

#endif
