// Boxes and faces of a mesh where an instance has them, sixteen at a time. Included once per instruction set.
#include "renderer/shadow/shaft/shaft-inl.h"

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

// Where a level of a dense mesh is drawn: boxes whose distance from the receivers' box is in [near, far).
struct Range {
  float low[3], high[3];  // of the receivers' box, shaft space
  float metres[3];        // of its axes
  float near_m = 0, far_m = 0;
  bool IsBounded() const { return near_m > 0 || far_m < hwy::HighestValue<float>(); }
};

// Bit per box that is not wholly nearer to the receivers' box, nor wholly further from it.
HWY_INLINE uint32_t BoxesWithin(const Boxes16& boxes, const Range& range) {
  Floats nearest = Set(0), furthest = Set(0);  // squared
  for (int axis = 0; axis < 3; ++axis) {
    const Floats below = Set(range.low[axis]) - Load(boxes.low[axis]);
    const Floats above = Load(boxes.high[axis]) - Set(range.high[axis]);
    const Floats metres = Set(range.metres[axis]);
    const Floats far = Max(Max(below, above), Set(0)) * metres;
    const Floats gap =
        Max(Max(Set(range.low[axis]) - Load(boxes.high[axis]), Load(boxes.low[axis]) - Set(range.high[axis])), Set(0)) *
        metres;
    nearest = nearest + gap * gap;
    furthest = furthest + far * far;
  }
  return Bits((nearest < Set(range.far_m * range.far_m)) & (furthest >= Set(range.near_m * range.near_m)));
}

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

HWY_INLINE Doubles LoadDoubles(const float* from) { return hn::PromoteTo(DoubleTag(), hn::Load(FewFloatsTag(), from)); }
HWY_INLINE void StoreFloats(const Doubles& from, float* to) {
  hn::Store(hn::DemoteTo(FewFloatsTag(), from), FewFloatsTag(), to);
}

// Sixteen polygons as arrays.
struct alignas(64) PlacedPolygons {
  float corners[3][4][16];  // [axis][corner]
  float normal[3][16], offset[16], size_m[16];
  uint32_t reversed[4];  // bit per polygon, for each edge
  uint32_t quads = 0, closed = 0;
  uint32_t flat = 0;  // without area: not to be used
  Polygon At(size_t lane) const {
    Polygon polygon;
    for (int k = 0; k < 4; ++k) {
      polygon.x[k] = corners[0][k][lane];
      polygon.y[k] = corners[1][k][lane];
      polygon.z[k] = corners[2][k][lane];
      polygon.reversed |= uint8_t((reversed[k] >> lane & 1) << k);
    }
    for (int axis = 0; axis < 3; ++axis) polygon.normal[axis] = normal[axis][lane];
    polygon.offset = offset[lane];
    polygon.size_m = size_m[lane];
    polygon.corners = (quads >> lane & 1) != 0 ? 4 : 3;
    polygon.is_closed = (closed >> lane & 1) != 0;
    return polygon;
  }
};

// Of faces that are not cut: to the bit what MakePolygons makes of each, by the same operations in the same order.
HWY_INLINE void PlacePolygons(const Faces16& faces, const ShapeInstance& instance, const ShaftSpace& space,
                              PlacedPolygons* placed) {
  const DoubleTag d;
  placed->quads = faces.quads;
  placed->closed = faces.closed;
  placed->flat = 0;
  // Corners in the light's frame, in the order that lets the plane point outward.
  alignas(64) float in_light[3][4][16];
  const glm::dmat4& m = instance.light_from_mesh;
  for (size_t lane = 0; lane < 16; lane += kDoubleLanes) {
    for (int k = 0; k < 4; ++k) {
      const Doubles x = LoadDoubles(faces.corners[k][0] + lane), y = LoadDoubles(faces.corners[k][1] + lane),
                    z = LoadDoubles(faces.corners[k][2] + lane);
      for (int row = 0; row < 3; ++row) {
        const Doubles xy = hn::Add(hn::Mul(hn::Set(d, m[0][row]), x), hn::Mul(hn::Set(d, m[1][row]), y));
        const Doubles zw = hn::Add(hn::Mul(hn::Set(d, m[2][row]), z), hn::Set(d, m[3][row]));
        StoreFloats(hn::Add(xy, zw), in_light[row][k] + lane);
      }
    }
  }
  const uint32_t turned = instance.is_mirrored ? faces.closed & ~faces.turned : faces.turned;
  if (turned != 0) {
    const Mask turns = LanesOf(turned), is_quad = LanesOf(faces.quads);
    for (auto& corners : in_light) {
      // The fourth of a triangle is its third.
      const Floats a = Load(corners[0]), b = Load(corners[1]), c = Load(corners[2]), last = Load(corners[3]);
      Store(Select(turns, last, a), corners[0]);
      Store(Select(turns, Select(is_quad, c, b), b), corners[1]);
      Store(Select(turns, Select(is_quad, b, a), c), corners[2]);
      Store(Select(turns, a, last), corners[3]);
    }
  }
  const Doubles scale[3] = {hn::Set(d, space.scale.x), hn::Set(d, space.scale.y), hn::Set(d, space.scale.z)};
  const Doubles shift[3] = {hn::Set(d, 0.5), hn::Set(d, 0.5), hn::Zero(d)};
  for (size_t lane = 0; lane < 16; lane += kDoubleLanes) {
    Doubles origin[3], arms[3][3], size = hn::Zero(d);  // arms[corner - 1][axis]
    for (int k = 0; k < 4; ++k) {
      Doubles corner_size = hn::Zero(d);
      for (int axis = 0; axis < 3; ++axis) {
        const Doubles p = LoadDoubles(in_light[axis][k] + lane);
        corner_size = hn::Add(corner_size, hn::Abs(p));
        StoreFloats(hn::Add(hn::Mul(p, scale[axis]), shift[axis]), placed->corners[axis][k] + lane);
        if (k == 0) {
          origin[axis] = p;
        } else {
          arms[k - 1][axis] = hn::Sub(p, origin[axis]);
        }
      }
      size = hn::Max(size, corner_size);
    }
    StoreFloats(size, placed->size_m + lane);
    Doubles normal[3], square = hn::Zero(d);
    for (int x = 0; x < 3; ++x) {
      const int y = (x + 1) % 3, z = (x + 2) % 3;
      const Doubles first = hn::Sub(hn::Mul(arms[0][y], arms[1][z]), hn::Mul(arms[1][y], arms[0][z]));
      const Doubles second = hn::Sub(hn::Mul(arms[1][y], arms[2][z]), hn::Mul(arms[2][y], arms[1][z]));
      normal[x] = hn::Add(first, second);
      square = hn::Add(square, hn::Mul(normal[x], normal[x]));
    }
    const Doubles area = hn::Sqrt(square);
    uint8_t has_area[8] = {};
    hn::StoreMaskBits(d, hn::Gt(area, hn::Zero(d)), has_area);
    placed->flat |= (~uint32_t(has_area[0]) & ((1u << kDoubleLanes) - 1)) << lane;
    Doubles offset = hn::Zero(d);
    for (int axis = 0; axis < 3; ++axis) {
      const Doubles in_shaft = hn::Div(hn::Div(normal[axis], area), scale[axis]);
      StoreFloats(in_shaft, placed->normal[axis] + lane);
      offset = hn::Add(offset, hn::Mul(in_shaft, hn::Add(hn::Mul(origin[axis], scale[axis]), shift[axis])));
    }
    StoreFloats(offset, placed->offset + lane);
  }
  const Mask is_quad = LanesOf(faces.quads);
  for (int k = 0; k < 4; ++k) {
    Floats from[3], to[3];
    for (int axis = 0; axis < 3; ++axis) {
      const Floats start = Load(placed->corners[axis][0]);
      from[axis] = Load(placed->corners[axis][k]);
      to[axis] = k == 3 ? start : Load(placed->corners[axis][k + 1]);
      if (k == 2) to[axis] = Select(is_quad, to[axis], start);
    }
    const Mask by_z = to[2] < from[2];
    const Mask by_y = (to[1] < from[1]) | ((to[1] == from[1]) & by_z);
    const Mask by_x = (to[0] < from[0]) | ((to[0] == from[0]) & by_y);
    placed->reversed[k] = Bits(by_x) & (k == 3 ? faces.quads : 0xffff);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace halfshade
HWY_AFTER_NAMESPACE();

#endif
