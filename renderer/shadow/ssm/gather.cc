#include "renderer/shadow/ssm/gather.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/light/sub_lights.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/shadow/ssm/gather.cc"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace halfshade {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr float kUlp = 1.1920929e-7f;
// Half a window never falls below this many texels: of a point light's map the nearest texels are mixed.
constexpr float kLeastHalfWindow = 0.5f;
// Over this part of a texel's change of w a texel comes to stand above a plane.
constexpr float kRampTexels = 0.25f;
// Rows of texels looked at one by one; of larger windows every second, third, ... row.
constexpr int kMostRows = 48;
// A texel's surface is carried so far toward the receiver: as far as the least window reaches beyond the texel's
// middle.
constexpr float kCarriedTexels = 1;
// By slopes against the light's plane of at most this; steeper ones are silhouettes.
constexpr float kSteepest = 8;

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

// What texels in front of the receiver hide, as shares of the window, and the mean of their depths beyond its own.
struct NearSum {
  float hidden = 0;
  float moment = 0;  // of depths ahead of the receiver's
};

// Texels of the box that are nearer than the receiver, above its plane, and before `end_place` of the slabs; the box
// holds their windows. Each in the window at its own depth, or all in the one at `at_ahead` beyond the receiver's
// depth.
NearSum SumNearTexels(const BinnedMap& map, const View& view, const TexelBox& box, float end_place,
                      float at_ahead = 0) {
  const hn::ScalableTag<float> d;
  const int lanes = int(hn::Lanes(d));
  const auto zero = hn::Zero(d);
  const auto one = hn::Set(d, 1.0f);
  const int stride = std::max(1, (box.y1 - box.y0 + kMostRows - 1) / kMostRows);
  auto total = zero;
  auto moment = zero;
  const auto steepest_x = hn::Set(d, kSteepest * float(map.slope_per_texel.x));
  const auto steepest_y = hn::Set(d, kSteepest * float(map.slope_per_texel.y));
  // The border is empty.
  for (int y = std::max(box.y0, 1); y < std::min(box.y1, map.map_size - 1); y += stride) {
    const float* row = &map.depths[size_t(y) * map.map_size];
    const float from_row = float(y + 0.5 - view.place.y);
    const float* row_away = from_row > 0 ? row + map.map_size : row - map.map_size;
    const auto distance_y = hn::Set(d, std::min(std::abs(from_row), kCarriedTexels));
    const auto above_row = hn::Set(d, from_row * view.b.y - view.least);
    const auto y_low = hn::Set(d, float(y - view.place.y));
    for (int x = box.x0; x < box.x1; x += lanes) {
      const auto shown = hn::LoadU(d, row + x);
      if (hn::AllFalse(d, hn::Gt(shown, hn::Set(d, view.depth)))) continue;
      const auto column = hn::Iota(d, float(x));
      const auto from_column = hn::Iota(d, float(x + 0.5 - view.place.x));
      const auto distance_x = hn::Min(hn::Abs(from_column), hn::Set(d, kCarriedTexels));
      const auto away_x =
          hn::IfThenElse(hn::Gt(from_column, zero), hn::LoadU(d, row + x + 1), hn::LoadU(d, row + x - 1));
      const auto fall_x = hn::Min(hn::Max(hn::Sub(away_x, shown), zero), hn::Mul(shown, steepest_x));
      const auto fall_y =
          hn::Min(hn::Max(hn::Sub(hn::LoadU(d, row_away + x), shown), zero), hn::Mul(shown, steepest_y));
      // The surface, carried by its slope toward the receiver where it falls off that way.
      const auto depth = hn::Sub(shown, hn::Add(hn::Mul(fall_x, distance_x), hn::Mul(fall_y, distance_y)));
      const auto ahead = hn::Sub(depth, hn::Set(d, view.depth));
      const auto place =
          hn::Mul(hn::Sub(shown, hn::Set(d, map.tables.first_depth)), hn::Set(d, map.tables.slabs_per_depth));
      const auto is_near = hn::And(hn::And(hn::Gt(ahead, zero), hn::Lt(place, hn::Set(d, end_place))),
                                   hn::Lt(column, hn::Set(d, float(map.map_size))));
      if (hn::AllFalse(d, is_near)) continue;
      const auto rise = hn::MulAdd(hn::Sub(shown, hn::Set(d, view.depth)), hn::Set(d, view.up),
                                   hn::MulAdd(from_column, hn::Set(d, view.b.x), above_row));
      const auto above = hn::NegMulAdd(shown, hn::Set(d, view.slack), rise);
      const auto weight = hn::Min(hn::Max(hn::Mul(above, hn::Set(d, view.per_ramp)), zero), one);
      const auto window = at_ahead > 0 ? hn::Set(d, at_ahead) : ahead;
      const auto half_x = hn::Max(hn::Mul(window, hn::Set(d, view.half.x)), hn::Set(d, kLeastHalfWindow));
      const auto half_y = hn::Max(hn::Mul(window, hn::Set(d, view.half.y)), hn::Set(d, kLeastHalfWindow));
      const auto middle_x = hn::Mul(window, hn::Set(d, view.middle.x));
      const auto middle_y = hn::Mul(window, hn::Set(d, view.middle.y));
      const auto x_low = hn::Iota(d, float(x - view.place.x));
      const auto cover_x =
          hn::Sub(hn::Min(hn::Add(x_low, one), hn::Add(middle_x, half_x)), hn::Max(x_low, hn::Sub(middle_x, half_x)));
      const auto cover_y =
          hn::Sub(hn::Min(hn::Add(y_low, one), hn::Add(middle_y, half_y)), hn::Max(y_low, hn::Sub(middle_y, half_y)));
      const auto cover = hn::Mul(hn::Max(cover_x, zero), hn::Max(cover_y, zero));
      const auto share = hn::IfThenElseZero(is_near, hn::Div(hn::Mul(cover, weight), hn::Mul(half_x, half_y)));
      total = hn::Add(total, share);
      moment = hn::MulAdd(share, ahead, moment);
    }
  }
  const float scale = float(stride) * 0.25f;
  return {scale * hn::GetLane(hn::SumOfLanes(d, total)), scale * hn::GetLane(hn::SumOfLanes(d, moment))};
}

// Whether any texel of the box would count in SumNearTexels for a receiver of at least `least_depth` in the view's
// plane.
bool HasNearTexel(const BinnedMap& map, const View& view, float least_depth, const TexelBox& box) {
  const hn::ScalableTag<float> d;
  const int lanes = int(hn::Lanes(d));
  const auto zero = hn::Zero(d);
  for (int y = box.y0; y < box.y1; ++y) {
    const float* row = &map.depths[size_t(y) * map.map_size];
    const float from_row = float(y + 0.5 - view.place.y);
    const auto above_row = hn::Set(d, from_row * view.b.y);
    for (int x = box.x0; x < box.x1; x += lanes) {
      const auto shown = hn::LoadU(d, row + x);
      const auto from_column = hn::Iota(d, float(x + 0.5 - view.place.x));
      const auto rise = hn::MulAdd(hn::Sub(shown, hn::Set(d, view.depth)), hn::Set(d, view.up),
                                   hn::MulAdd(from_column, hn::Set(d, view.b.x), above_row));
      const auto above = hn::NegMulAdd(shown, hn::Set(d, view.slack), rise);
      if (!hn::AllFalse(d, hn::And(hn::Gt(shown, hn::Set(d, least_depth)), hn::Gt(above, zero)))) return true;
    }
  }
  return false;
}

int LastSlabUpTo(const DepthTables& tables, float depth) {
  if (depth < tables.first_depth) return -1;
  return int(std::min(tables.PlaceOf(depth), float(tables.slabs - 1)));
}

// What the tables prove for a whole tile.
struct TileProof {
  bool is_lit = false;   // nothing nearer is in reach of any receiver
  bool is_dark = false;  // slabs beyond cover all that any looks at: HiddenFraction is 1 for each
  bool has_near_texels = true;
  int top_slab = 0;  // no nearer one is in reach
};

float HiddenFraction(const BinnedMap& map, const View& view, const TileProof& proof) {
  const DepthTables& tables = map.tables;
  const int slabs = tables.slabs;
  const int near_slab = LastSlabUpTo(tables, view.near_depth);
  // The window narrows until it holds the slab that it is as wide as: the same one wherever the search began.
  uint32_t sums[DepthTables::EntryOf(DepthTables::kMaxSlabs)];
  TexelBox box;
  float nearest = 0;
  int top_slab = 0;
  for (int next = proof.top_slab;;) {
    top_slab = next;
    nearest = std::min(tables.nearest_depth, tables.SlabStart(next + 1));
    if (nearest <= view.depth) return 0;
    box = InPatches(Reach(view, nearest, map.map_size), map.texels_per_patch);
    if (box.IsEmpty()) return 0;
    SumBox(tables, box, sums);
    if (sums[0] == 0) return 0;
    while (sums[next] == 0) --next;
    if (next == top_slab) break;
  }
  const uint32_t area_beyond = near_slab + 1 < slabs ? sums[near_slab + 1] : 0u;
  const uint32_t full = DepthTables::kFullPatch * uint32_t(box.x1 - box.x0) * uint32_t(box.y1 - box.y0);
  if (area_beyond == full) return 1;

  float hidden = 0;
  float moment = 0;
  for (int slab = near_slab + 1; slab <= top_slab; ++slab) {
    const uint32_t area = sums[slab] - (slab + 1 < slabs ? sums[slab + 1] : 0u);
    if (area == 0) continue;
    const float place = float(sums[slabs + slab]) / (DepthTables::kPlaces * float(area));
    const float ahead = tables.SlabStart(slab) + place * tables.slab_depth - view.depth;
    const PatchWindow window = WindowAt(view, ahead, map.texels_per_patch);
    const float share = CoveredShare(tables, slab, false, window);
    hidden += share;
    moment += share * ahead;
  }
  NearSum near;
  TexelBox near_box;
  float near_end = 0;
  if (proof.has_near_texels && near_slab >= 0 && sums[0] > area_beyond) {
    const bool is_last = near_slab + 1 >= slabs;
    near_end = is_last ? std::numeric_limits<float>::infinity() : float(near_slab + 1);
    near_box = Reach(view, is_last ? nearest : std::min(nearest, tables.SlabStart(near_slab + 1)), map.map_size);
    near = SumNearTexels(map, view, near_box, near_end);
  }
  hidden += near.hidden;
  moment += near.moment;
  if (!(hidden > 0)) return 0;
  // Images of patches at different depths leave gaps and overlap. At their mean depth there are none: what is seen
  // there and what is hidden make up the light.
  const float ahead = moment / hidden;
  const PatchWindow window = WindowAt(view, ahead, map.texels_per_patch);
  float seen = 1;
  if (area_beyond > 0) seen -= CoveredShare(tables, near_slab + 1, true, window);
  if (near.hidden > 0) {
    near_box = Reach(view, view.depth + ahead, map.map_size);
    seen -= SumNearTexels(map, view, near_box, near_end, ahead).hidden;
  }
  constexpr float kNothing = 16 * kUlp;  // of a sum of shares
  return seen > kNothing ? hidden / (hidden + seen) : 1;
}

// All texels that any receiver of the tile may look at through this sub-light, up to `depth`.
TexelBox ReachOfTile(const BinnedMap& map, const glm::vec2& half_edges, const ReceiverTile& tile, float depth) {
  const glm::dvec2 moved_low = map.point * tile.w_low, moved_high = map.point * tile.w_high;
  View view;
  view.depth = float(tile.w_low * map.z_near);
  view.half = half_edges / glm::vec2(map.z_near * map.slope_per_texel);
  const auto to_texel = [&](const glm::dvec2& slope) { return (slope - map.first_center) / map.slope_per_texel + 0.5; };
  // A quarter of a texel is far more than what floats may be off.
  view.place = to_texel(tile.slope_low - glm::max(moved_low, moved_high)) - 0.25;
  const TexelBox low = Reach(view, depth, map.map_size);
  view.place = to_texel(tile.slope_high - glm::min(moved_low, moved_high)) + 0.25;
  const TexelBox high = Reach(view, depth, map.map_size);
  return {low.x0, low.y0, high.x1, high.y1};
}

TileProof Prove(const BinnedMap& map, const glm::vec2& half_edges, const ReceiverTile& tile) {
  const DepthTables& tables = map.tables;
  const float depth_low = float(tile.w_low * map.z_near);
  TileProof proof;
  TexelBox box;
  uint32_t sums[DepthTables::EntryOf(DepthTables::kMaxSlabs)];
  for (int next = tables.slabs - 1;;) {
    proof.top_slab = next;
    const float nearest = std::min(tables.nearest_depth, tables.SlabStart(next + 1));
    box = ReachOfTile(map, half_edges, tile, nearest);
    proof.is_lit = nearest <= depth_low || box.IsEmpty();
    if (proof.is_lit) return proof;
    SumBox(tables, InPatches(box, map.texels_per_patch), sums);
    proof.is_lit = sums[0] == 0;
    if (proof.is_lit) return proof;
    while (sums[next] == 0) --next;
    if (next == proof.top_slab) break;
  }
  if (!tile.shares_plane) return proof;
  View view = MakeView(map, {1, glm::vec2(0), half_edges}, tile, 0);
  const int first_beyond = LastSlabUpTo(tables, view.near_depth + float(tile.w_high * map.z_near) - view.depth) + 1;
  box = InPatches(box, map.texels_per_patch);
  const uint32_t full = DepthTables::kFullPatch * uint32_t(box.x1 - box.x0) * uint32_t(box.y1 - box.y0);
  proof.is_dark = first_beyond < tables.slabs && sums[first_beyond] == full;
  if (proof.is_dark || first_beyond == 0) return proof;
  // Half of what the surest of them would take for the plane itself: they agree about it to some ulps only.
  float least_error = tile.error[0];
  for (int i = 1; i < tile.count; ++i) least_error = std::min(least_error, tile.error[i]);
  view.slack = 0.5f * (view.slack - tile.error[0] / float(map.z_near) + least_error / float(map.z_near));
  box = ReachOfTile(map, half_edges, tile, std::min(tables.nearest_depth, tables.SlabStart(proof.top_slab + 1)));
  proof.has_near_texels = HasNearTexel(map, view, depth_low, box);
  return proof;
}

// The map does not reach as far as this receiver looks.
bool LeavesMap(const BinnedMap& map, const glm::vec2& half_edges, const ReceiverTile& tile, int i) {
  const glm::dvec2 slope = glm::abs(glm::dvec2(tile.u[i], tile.v[i]) - map.point * tile.w[i]);
  const double ahead = std::max(map.tables.nearest_depth / map.z_near - tile.w[i], 0.0);
  const glm::dvec2 reach = slope + glm::dvec2(half_edges) * ahead + 2.0 * map.slope_per_texel;
  return std::max(reach.x, reach.y) > map.side_slope;
}

void GatherTile(std::span<const BinnedMap> layers, const glm::vec2& half_edges, const ReceiverTile& tile,
                const float* hidden_point, float* hidden, float* share) {
  const BinnedMap& nearest = layers[0];
  const glm::vec2 point(nearest.point);
  TileProof proofs[2];
  proofs[0] = Prove(nearest, half_edges, tile);
  for (size_t k = 1; k < layers.size() && !proofs[0].is_lit; ++k) proofs[k] = Prove(layers[k], half_edges, tile);
  for (int i = 0; i < tile.count; ++i) {
    const glm::vec2 normal(tile.normal_x[i], tile.normal_y[i]);
    const LitPart part = tile.sees_whole_light ? LitPart{1, glm::vec2(0), half_edges}
                                               : CutCell(half_edges, normal, tile.height[i] + glm::dot(normal, point));
    if (part.share <= 0) continue;
    share[tile.index[i]] += part.share;
    float fraction = 0;
    if (hidden_point != nullptr && LeavesMap(nearest, half_edges, tile, i)) {
      fraction = hidden_point[tile.index[i]];
    } else if (!proofs[0].is_lit) {
      for (size_t k = 0; k < layers.size() && fraction < 1; ++k) {
        if (proofs[k].is_lit) continue;
        fraction = proofs[k].is_dark
                       ? 1
                       : std::max(fraction, HiddenFraction(layers[k], MakeView(layers[k], part, tile, i), proofs[k]));
      }
    }
    hidden[tile.index[i]] += part.share * fraction;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace halfshade
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace halfshade {

HWY_EXPORT(GatherTile);

void GatherTile(std::span<const BinnedMap> layers, const glm::vec2& half_edges, const ReceiverTile& tile,
                const float* hidden_point, float* hidden, float* share) {
  HWY_DYNAMIC_DISPATCH(GatherTile)(layers, half_edges, tile, hidden_point, hidden, share);
}

}  // namespace halfshade
#endif  // HWY_ONCE
