// Polygons of a mesh where an instance has them, sixteen at a time. Included once per instruction set.
#include "renderer/shadow/shaft/place-inl.h"

#if defined(HALFSHADE_SHAFT_PLACED_POLYGONS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef HALFSHADE_SHAFT_PLACED_POLYGONS_INL_H_
#undef HALFSHADE_SHAFT_PLACED_POLYGONS_INL_H_
#else
#define HALFSHADE_SHAFT_PLACED_POLYGONS_INL_H_
#endif

#include "renderer/shadow/shaft/mesh_shape.h"

HWY_BEFORE_NAMESPACE();
namespace halfshade {
namespace HWY_NAMESPACE {

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
