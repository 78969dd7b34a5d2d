// The light as rows of 32 bits a lane, and polygons drawn on it as a lane's receiver sees them.
//
// Row r holds the samples i at x = (i + f) / 32, y = (r - rise + lean x) / R: f from the row and the receiver, lean a
// whole number, the block's, rise the receiver's. Rows lean so that an edge along the light's side cuts a few of them,
// each to a sample; blocks lean differently, since an edge along the rows is met badly. There are R + |lean| rows: the
// last |lean| go on where the first ones leave the light, so N = 32 R. In the axes (x, R y - lean x + rise) rows are
// horizontal and whole numbers. Included once per instruction set.
#include "renderer/shadow/shaft/lanes-inl.h"

#if defined(HALFSHADE_SHAFT_BITMASK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef HALFSHADE_SHAFT_BITMASK_INL_H_
#undef HALFSHADE_SHAFT_BITMASK_INL_H_
#else
#define HALFSHADE_SHAFT_BITMASK_INL_H_
#endif

#include "renderer/shadow/shaft/polygons.h"
#include "renderer/shadow/shaft/tile.h"

HWY_BEFORE_NAMESPACE();
namespace halfshade {
namespace HWY_NAMESPACE {

constexpr int kColumns = 32;
constexpr int kMostRows = 64 + 64 * 5 / 16;
constexpr float kFourUlps = 4 * 1.1920929e-7f;

// Sixteen receivers.
struct Receivers16 {
  Floats x, y, z;
  Floats normal_x, normal_y, normal_z, error_m;
  uint32_t active = 0;
  bool is_loose = false;
};

// What of the light is hidden so far.
struct LightRows {
  int rows = 0;   // R
  int count = 0;  // R + |lean|
  float lean = 0;
  Floats rise;
  Words hidden[kMostRows];        // a bit that is no sample, or is below the receiver's plane, is set from the start
  Floats above[kMostRows];        // 1/2 - f: bit i is beyond x = t / 32 from the whole number nearest to t + above on
  Words preset_even, preset_odd;  // set at the start, in even and odd rows
};

// The part of the light on one side of P x + Q r + S = 0: bits of row r where it is positive.
struct HalfPlane {
  Floats slope, start;  // in bits: of its edge at row r, slope r + start
  Words flip;
  HWY_INLINE Words At(const Floats& row, const Floats& above) const {
    return BitsFrom(slope * row + start + above) ^ flip;
  }
};

// `turned`: sign bit set: the negative side.
HWY_INLINE HalfPlane MakeHalfPlane(const Floats& p, const Floats& q, const Floats& s, const Floats& turned) {
  // Where it runs along the rows, P is 0 and the sign of the rest decides.
  const Floats least = (Abs(q) + Abs(s)) * Set(1e-12f) + Set(1e-30f);
  const Floats divisor = CopySign(Max(Abs(p), least), p);
  const Floats scale = Set(-float(kColumns)) / divisor;
  return {q * scale, s * scale, SpreadSign(p) ^ SpreadSign(turned)};
}

HWY_INLINE Words CountEven(const LightRows& light, int first) {
  Words sum = SetWords(0);
  for (int r = first; r < light.count; r += 2) sum = sum + CountOnes(light.hidden[r]);
  return sum;
}

// Marks what is no sample or, of lanes that the plane cuts, stands below it. `row_shift`: R values in [0,1).
HWY_INLINE void StartRows(const Tile& tile, int block, int rows, int lean, const float* row_shift, LightRows* light) {
  const int first = block * Tile::kLanes, steps = HWY_MAX(lean, -lean), base = HWY_MAX(lean, 0);
  const Floats shift = Load(tile.shift_x + first), one = Set(1);
  light->rows = rows;
  light->count = rows + steps;
  light->lean = float(lean);
  light->rise = Set(float(base)) - Load(tile.shift_y + first);
  const Words all = SetWords(~0u), inactive = all ^ AsWords(LanesOf(tile.active[block]));
  const Floats slope = Set(light->lean), size = Set(float(rows));
  const HalfPlane from_start = MakeHalfPlane(slope, one, Set(0) - light->rise, one);
  const HalfPlane to_end = MakeHalfPlane(Set(0) - slope, Set(-1), light->rise + size, one);
  const Floats up_y = Load(tile.up_y + first) / size;
  const HalfPlane above_plane =
      MakeHalfPlane(Load(tile.up_x + first) + up_y * slope, up_y, Load(tile.up + first) - up_y * light->rise, one);
  const Words cut = AsWords(LanesOf(tile.cut[block]));
  for (int r = 0; r < light->count; ++r) {
    const Floats row = Set(float(r));
    const Floats f = shift + Set(row_shift[(r + rows - base) % rows]);
    light->above[r] = Set(0.5f) - Select(f >= one, f - one, f);
    light->hidden[r] = inactive;
    if (r < steps || r >= rows) {
      light->hidden[r] =
          light->hidden[r] | (all ^ (from_start.At(row, light->above[r]) & to_end.At(row, light->above[r])));
    }
    if (tile.cut[block] != 0) {
      light->hidden[r] = light->hidden[r] | ((all ^ above_plane.At(row, light->above[r])) & cut);
    }
  }
  light->preset_even = CountEven(*light, 0);
  light->preset_odd = CountEven(*light, 1);
}

HWY_INLINE bool IsAllHidden(const LightRows& light) {
  Words all = light.hidden[0];
  for (int r = 1; r < light.count; ++r) all = all & light.hidden[r];
  return AllOnes(all);
}

// Hands what the polygon hides from receivers that it stands above of to `hide`, row by row: hide(r, bits).
template <int kCorners, typename Hide>
HWY_INLINE void DrawPolygon(const Polygon& polygon, const Receivers16& at, const LightRows* light, const Hide& hide) {
  const Floats zero = Set(0);
  Floats arm_x[kCorners], arm_y[kCorners], arm_z[kCorners];
  for (int k = 0; k < kCorners; ++k) {
    arm_x[k] = Set(polygon.x[k]) - at.x;
    arm_y[k] = Set(polygon.y[k]) - at.y;
    arm_z[k] = Set(polygon.z[k]) - at.z;
  }
  Mask draws = LanesOf(at.active);
  const Floats error = at.error_m + Set(kFourUlps * polygon.size_m);
  // A receiver that stands in the polygon's plane, as far as floats can tell, sees it edge-on or lies on it.
  const Floats distance =
      arm_x[0] * Set(polygon.normal[0]) + arm_y[0] * Set(polygon.normal[1]) + arm_z[0] * Set(polygon.normal[2]);
  // On a closed surface it must be seen from behind, too.
  draws = draws & ((polygon.is_closed ? distance : Abs(distance)) > error);
  if (!at.is_loose) {
    Floats height = arm_x[0] * at.normal_x + arm_y[0] * at.normal_y + arm_z[0] * at.normal_z;
    for (int k = 1; k < kCorners; ++k) {
      height = Max(height, arm_x[k] * at.normal_x + arm_y[k] * at.normal_y + arm_z[k] * at.normal_z);
    }
    draws = draws & (height > error);
  }
  if (!Any(draws)) return;
  Floats deepest = arm_z[0];
  for (int k = 1; k < kCorners; ++k) deepest = Max(deepest, arm_z[k]);

  const Floats lean = Set(light->lean);
  int first_row = 0, last_row = light->count - 1;
  HalfPlane edges[kCorners];
  // Corners this near to the receiver's depth, or beyond it, have no place on the light.
  constexpr float kLeastDepth = 1.0f / 4096;
  if (!Any(draws & (deepest > at.z * Set(-kLeastDepth)))) {
    Floats px[kCorners], py[kCorners];
    const Floats rows = Set(float(light->rows)), last = Set(float(light->count - 1));
    for (int k = 0; k < kCorners; ++k) {
      const Floats along = at.z / arm_z[k];
      px[k] = at.x - arm_x[k] * along;
      py[k] = (at.y - arm_y[k] * along) * rows - px[k] * lean + light->rise;
    }
    Floats low_x = px[0], high_x = px[0], low_y = py[0], high_y = py[0];
    for (int k = 1; k < kCorners; ++k) {
      low_x = Min(low_x, px[k]);
      high_x = Max(high_x, px[k]);
      low_y = Min(low_y, py[k]);
      high_y = Max(high_y, py[k]);
    }
    draws = draws & (low_x < Set(1)) & (high_x > zero) & (low_y <= last) & (high_y >= zero);
    // Twice the signed area: positive where its front is seen.
    Floats area = (px[1] - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (py[1] - py[0]);
    if (kCorners == 4) {
      area = area + (px[2] - px[0]) * (py[3 % kCorners] - py[0]) - (px[3 % kCorners] - px[0]) * (py[2] - py[0]);
    }
    // Without an area, to floats, it has no inside.
    draws = draws & (polygon.is_closed ? area < zero : Abs(area) > zero);
    if (!Any(draws)) return;
    // Rows that some lane's polygon reaches, and a little more: beyond a polygon its half planes leave nothing.
    const float reach_low = Least(Select(draws, low_y, last)), reach_high = Greatest(Select(draws, high_y, zero));
    first_row = int(HWY_MAX(reach_low - 0.01f, 0.0f));
    last_row = int(HWY_MIN(reach_high + 0.01f, float(light->count - 1)));
    for (int k = 0; k < kCorners; ++k) {
      const int j = (k + 1) % kCorners;
      const Floats rise = py[j] - py[k];
      const Floats divisor = CopySign(Max(Abs(rise), Set(1e-9f)), rise);
      const Floats slope = (px[j] - px[k]) * Set(float(kColumns)) / divisor;
      // From the same corner as the polygon beside it does: where one ends the other begins, to the bit.
      const int from = (polygon.reversed >> k & 1) != 0 ? j : k;
      edges[k] = {slope, px[from] * Set(float(kColumns)) - slope * py[from],
                  SpreadSign(rise) ^ SpreadSign(area) ^ SetWords(~0u)};
    }
  } else {
    // Planes through the receiver and the edges: right wherever the corners are.
    Floats nx[kCorners], ny[kCorners], nz[kCorners];
    for (int k = 0; k < kCorners; ++k) {
      const int j = (k + 1) % kCorners;
      nx[k] = arm_y[k] * arm_z[j] - arm_z[k] * arm_y[j];
      ny[k] = arm_z[k] * arm_x[j] - arm_x[k] * arm_z[j];
      nz[k] = arm_x[k] * arm_y[j] - arm_y[k] * arm_x[j];
    }
    // Positive where its back is seen.
    Floats volume = arm_x[2] * nx[0] + arm_y[2] * ny[0] + arm_z[2] * nz[0];
    if (kCorners == 4) volume = volume + arm_x[0] * nx[2] + arm_y[0] * ny[2] + arm_z[0] * nz[2];
    draws = draws & ((polygon.is_closed ? volume : Abs(volume)) > zero);
    if (!Any(draws)) return;
    const Floats per_row = Set(1 / float(light->rows));
    for (int k = 0; k < kCorners; ++k) {
      const Floats q = ny[k] * per_row;
      const Floats at_corner = zero - (nx[k] * at.x + ny[k] * at.y + nz[k] * at.z);
      edges[k] = MakeHalfPlane(nx[k] + q * lean, q, at_corner - q * light->rise, volume);
    }
  }
  // Lanes that do not draw have an edge that leaves nothing.
  edges[0].slope = Select(draws, edges[0].slope, zero);
  edges[0].start = Select(draws, edges[0].start, Set(1e9f));
  edges[0].flip = edges[0].flip & AsWords(draws);
  for (int r = first_row; r <= last_row; ++r) {
    const Floats row = Set(float(r));
    Words inside = edges[0].At(row, light->above[r]);
    for (int k = 1; k < kCorners; ++k) inside = inside & edges[k].At(row, light->above[r]);
    hide(r, inside);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace halfshade
HWY_AFTER_NAMESPACE();

#endif
