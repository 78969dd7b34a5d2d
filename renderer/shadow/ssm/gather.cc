#include "renderer/shadow/ssm/gather.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/shadow/ssm/gather.cc"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include "renderer/shadow/ssm/window-inl.h"

HWY_BEFORE_NAMESPACE();
namespace halfshade {
namespace HWY_NAMESPACE {

// Rows of texels looked at one by one; of larger windows every second, third, ... row.
constexpr int kMostRows = 48;
// A texel's surface is carried so far toward the receiver: as far as the least window reaches beyond the texel's
// middle.
constexpr float kCarriedTexels = 1;
// By slopes against the light's plane of at most this; steeper ones are silhouettes.
constexpr float kSteepest = 8;

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
