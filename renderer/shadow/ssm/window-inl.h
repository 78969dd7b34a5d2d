// A receiver's view of a binned map, and what the map's tables hold of a window. Included once per instruction set.
#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/light/binned_map.h"
#include "renderer/light/receiver_tile.h"
#include "renderer/light/sub_lights.h"

// After the others: Highway's own guard.
#include <hwy/highway.h>

#if defined(HALFSHADE_SSM_WINDOW_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef HALFSHADE_SSM_WINDOW_INL_H_
#undef HALFSHADE_SSM_WINDOW_INL_H_
#else
#define HALFSHADE_SSM_WINDOW_INL_H_
#endif

HWY_BEFORE_NAMESPACE();
namespace halfshade {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr float kUlp = 1.1920929e-7f;
// Half a window never falls below this many texels: of a point light's map the nearest texels are mixed.
constexpr float kLeastHalfWindow = 0.5f;
// Over this part of a texel's change of w a texel comes to stand above a plane.
constexpr float kRampTexels = 0.25f;

// Texels [x0, x1) x [y0, y1).
struct TexelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool IsEmpty() const { return x1 <= x0 || y1 <= y0; }
};

// One receiver before one map: positions in texels of the map from its corner, depths w z_near.
struct View {
  glm::dvec2 place{0};  // of the receiver
  float depth = 0;      // of the receiver
  glm::vec2 middle{0};  // the window's middle moves by this a unit of depth
  glm::vec2 half{0};    // and its half width grows by this
  // What is `ahead` of the receiver's depth and `from` its place stands above its plane by ahead up + from . b, less
  // depth slack and `least`; it counts in full a ramp further.
  float up = 0, slack = 0;
  glm::vec2 b{0};
  float least = 0, per_ramp = 0;
  float near_depth = 0;  // up to here the receiver's own surface may reach into a window
};

View MakeView(const BinnedMap& map, const LitPart& part, const ReceiverTile& tile, int i) {
  View view;
  const float z_near = float(map.z_near);
  const glm::vec2 point(map.point);
  const glm::vec2 slope_per_texel(map.slope_per_texel);
  const glm::dvec2 slope = glm::dvec2(tile.u[i], tile.v[i]) - map.point * tile.w[i];
  view.place = (slope - map.first_center) / map.slope_per_texel + 0.5;
  view.depth = float(tile.w[i] * map.z_near);
  view.middle = part.middle / (z_near * slope_per_texel);
  view.half = part.half_edges / (z_near * slope_per_texel);
  const glm::vec2 normal(tile.normal_x[i], tile.normal_y[i]);
  const float height = tile.height[i] + glm::dot(normal, point);
  view.up = height / z_near;
  view.slack = (4 * kUlp * std::abs(height) + tile.error[i]) / z_near;
  view.b = normal * slope_per_texel;
  const float change = std::abs(view.b.x) + std::abs(view.b.y);
  view.least = 1e-3f * change;
  view.per_ramp = 1 / (kRampTexels * change + std::numeric_limits<float>::min());
  // Of the plane itself nothing is in the cone from the receiver to the light. But a window is widened by patches that
  // it cuts, and of a slab it is as wide as at the mean depth: up to here that may take in the plane. More, where the
  // light's edge comes near to the plane.
  const float half_rise = glm::dot(glm::abs(normal), part.half_edges);
  const float lowest = height + glm::dot(normal, part.middle) - half_rise;
  const float rise = 2 * float(map.texels_per_patch) * change * z_near + 2 * half_rise * map.tables.slab_depth +
                     tile.error[i] * view.depth;
  view.near_depth = view.depth * (1 + 8 * kUlp) + (rise > 0 ? rise / std::max(lowest, 1e-3f * rise) : 0);
  return view;
}

// All texels that windows of depths from the receiver's to `depth` touch, within the map.
TexelBox Reach(const View& view, float depth, int map_size) {
  const float ahead = std::max(depth - view.depth, 0.0f);
  const glm::vec2 below = glm::min((view.middle - view.half) * ahead, glm::vec2(0)) - kLeastHalfWindow;
  const glm::vec2 above = glm::max((view.middle + view.half) * ahead, glm::vec2(0)) + kLeastHalfWindow;
  const glm::dvec2 size{double(map_size)};
  const glm::ivec2 first(glm::floor(glm::clamp(view.place + glm::dvec2(below), glm::dvec2(0), size)));
  const glm::ivec2 last(glm::ceil(glm::clamp(view.place + glm::dvec2(above), glm::dvec2(0), size)));
  return {first.x, first.y, last.x, last.y};
}

// In whole patches around it.
TexelBox InPatches(const TexelBox& box, int texels_per_patch) {
  const int t = texels_per_patch;
  return {box.x0 / t, box.y0 / t, (box.x1 + t - 1) / t, (box.y1 + t - 1) / t};
}

// Box sums of all of an entry.
void SumBox(const DepthTables& tables, const TexelBox& box, uint32_t* sums) {
  const hn::CappedTag<uint32_t, 4> d;
  const uint32_t* low = tables.At(box.x0, box.y0);
  const uint32_t* right = tables.At(box.x1, box.y0);
  const uint32_t* below = tables.At(box.x0, box.y1);
  const uint32_t* corner = tables.At(box.x1, box.y1);
  for (int i = 0; i < tables.entry; i += int(hn::Lanes(d))) {
    const auto lower = hn::Sub(hn::LoadU(d, corner + i), hn::LoadU(d, below + i));
    hn::StoreU(hn::Sub(lower, hn::Sub(hn::LoadU(d, right + i), hn::LoadU(d, low + i))), d, sums + i);
  }
}

// The places where one axis of a window cuts the table, and their weights: entries between are interpolated.
struct Cuts {
  int at[4];
  float weight[4];  // of the first: none, sums are told from there
};

Cuts MakeCuts(double low, double high, int size) {
  low = std::clamp(low, 0.0, double(size));
  high = std::clamp(high, 0.0, double(size));
  const int first = std::min(int(low), size - 1);
  const int last = std::min(int(high), size - 1);
  const float low_part = float(low - first);
  const float high_part = float(high - last);
  return {{first, first + 1, last, last + 1}, {0, -low_part, 1 - high_part, high_part}};
}

// The window at `ahead` beyond the receiver's depth, in patches.
struct PatchWindow {
  glm::dvec2 middle;
  glm::vec2 half;
};

PatchWindow WindowAt(const View& view, float ahead, int texels_per_patch) {
  const glm::dvec2 middle = view.place + glm::dvec2(view.middle * ahead);
  const glm::vec2 half = glm::max(view.half * ahead, glm::vec2(kLeastHalfWindow));
  return {middle / double(texels_per_patch), half / float(texels_per_patch)};
}

// Share of the window that slab `slab` covers; and, with `and_nearer`, all nearer ones.
float CoveredShare(const DepthTables& tables, int slab, bool and_nearer, const PatchWindow& window) {
  const Cuts x = MakeCuts(window.middle.x - window.half.x, window.middle.x + window.half.x, tables.size);
  const Cuts y = MakeCuts(window.middle.y - window.half.y, window.middle.y + window.half.y, tables.size);
  const bool leaves_out = !and_nearer && slab + 1 < tables.slabs;
  const auto area = [&](int column, int row) {
    const uint32_t* entry = tables.At(column, row) + slab;
    return entry[0] - (leaves_out ? entry[1] : 0u);
  };
  uint32_t top[4];
  for (int i = 0; i < 4; ++i) top[i] = area(x.at[i], y.at[0]);
  float sum = 0;
  for (int j = 1; j < 4; ++j) {
    const uint32_t left = area(x.at[0], y.at[j]);
    float row = 0;
    for (int i = 1; i < 4; ++i) row += x.weight[i] * float(area(x.at[i], y.at[j]) - left - top[i] + top[0]);
    sum += y.weight[j] * row;
  }
  return sum / (4 * float(DepthTables::kFullPatch) * window.half.x * window.half.y);
}

}  // namespace HWY_NAMESPACE
}  // namespace halfshade
HWY_AFTER_NAMESPACE();

#endif
