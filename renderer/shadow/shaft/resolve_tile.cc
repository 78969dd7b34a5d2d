#include "renderer/shadow/shaft/resolve_tile.h"

#include <algorithm>
#include <bit>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/shadow/shaft/resolve_tile.cc"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include "renderer/shadow/shaft/masked_view.h"
#include "renderer/shadow/shaft/query-inl.h"

HWY_BEFORE_NAMESPACE();
namespace halfshade {
namespace HWY_NAMESPACE {

// Samples that BLEND was asked for, a lane, and how many of them it hid.
struct Tosses {
  uint32_t asked[Tile::kLanes] = {}, hid[Tile::kLanes] = {};
};

// Samples that a masked triangle covers are hidden where its mask leaves it.
template <int kCorners>
void DrawMasked(const Polygon& polygon, const MaskedTriangle& triangle, const RayMask& mask, const Tile& tile,
                int block, const Receivers16& at, LightRows* light, Tosses* tosses) {
  alignas(64) uint32_t hidden[Tile::kLanes], asked[Tile::kLanes];
  alignas(64) float above[Tile::kLanes];
  alignas(64) float rise[Tile::kLanes];
  MaskedView views[Tile::kLanes];
  uint32_t viewed = 0;  // bit per lane
  Store(light->rise, rise);
  DrawPolygon<kCorners>(polygon, at, light, [&](int r, const Words& inside) {
    const Words open = inside & (light->hidden[r] ^ SetWords(~0u));
    uint32_t lanes = LanesWithBits(open);
    if (lanes == 0) return;
    Store(open, asked);
    Store(light->hidden[r], hidden);
    Store(light->above[r], above);
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto lane = uint32_t(hwy::Num0BitsBelowLS1Bit_Nonzero32(lanes));
      if ((viewed >> lane & 1) == 0) {
        const size_t i = size_t(block) * Tile::kLanes + lane;
        views[lane] = MaskedView(triangle, mask, {tile.x[i], tile.y[i], tile.z[i]});
        viewed |= 1u << lane;
      }
      const uint32_t before = hidden[lane];
      for (uint32_t bits = asked[lane]; bits != 0; bits &= bits - 1) {
        const auto column = uint32_t(hwy::Num0BitsBelowLS1Bit_Nonzero32(bits));
        const float x = (float(column) + 0.5f - above[lane]) / float(kColumns);
        const float y = (float(r) - rise[lane] + light->lean * x) / float(light->rows);
        if (!views[lane].IsMaskedAway(mask, x, y)) hidden[lane] |= 1u << column;
      }
      tosses->asked[lane] += uint32_t(std::popcount(asked[lane]));
      tosses->hid[lane] += uint32_t(std::popcount(hidden[lane] ^ before));
    }
    light->hidden[r] = LoadWords(hidden);
  });
}

// Draws polygons until nothing of the light is left.
uint64_t DrawList(const PolygonTree& tree, const std::vector<RayMask>& masks, const TileScratch& lists,
                  const Tile& tile, int block, LightRows* light, Tosses* tosses) {
  constexpr size_t kCheckEvery = 4;
  const int first = block * Tile::kLanes;
  Receivers16 at;
  at.x = Load(tile.x + first);
  at.y = Load(tile.y + first);
  at.z = Load(tile.z + first);
  at.normal_x = Load(tile.normal_x + first);
  at.normal_y = Load(tile.normal_y + first);
  at.normal_z = Load(tile.normal_z + first);
  at.error_m = Load(tile.error_m + first);
  at.active = tile.active[block];
  at.is_loose = tile.is_loose;
  Tosses no_tosses;
  const auto hide = [light](int r, const Words& inside) { light->hidden[r] = light->hidden[r] | inside; };
  for (size_t i = 0; i < lists.block.size(); ++i) {
    const Polygon& polygon = lists.tile[lists.block[i]];
    if (polygon.masked >= 0) {
      const MaskedTriangle& triangle = tree.masked[polygon.masked];
      const RayMask& mask = masks[triangle.mask];
      Tosses* const here = mask.is_blend() ? tosses : &no_tosses;
      if (polygon.corners == 4) {
        DrawMasked<4>(polygon, triangle, mask, tile, block, at, light, here);
      } else {
        DrawMasked<3>(polygon, triangle, mask, tile, block, at, light, here);
      }
    } else if (polygon.corners == 4) {
      DrawPolygon<4>(polygon, at, light, hide);
    } else {
      DrawPolygon<3>(polygon, at, light, hide);
    }
    if (i % kCheckEvery == kCheckEvery - 1 && IsAllHidden(*light)) return i + 1;
  }
  return lists.block.size();
}

// Mean |error| of n tosses of which k hid, sqrt(2 / pi) of their deviation, sqrt(k (n - k) / n).
constexpr float kErrorOfDeviation = 0.8f;

// Counts what is hidden of what is above the plane.
HWY_INLINE void CountHidden(const LightRows& light, const Tile& tile, int block, const Tosses& tosses,
                            TileResult* result) {
  alignas(64) uint32_t even[Tile::kLanes], odd[Tile::kLanes], preset_even[Tile::kLanes], preset_odd[Tile::kLanes];
  Store(CountEven(light, 0), even);
  Store(CountEven(light, 1), odd);
  Store(light.preset_even, preset_even);
  Store(light.preset_odd, preset_odd);
  for (int lane = 0; lane < Tile::kLanes; ++lane) {
    if ((tile.active[block] >> lane & 1) == 0) continue;
    const int i = block * Tile::kLanes + lane;
    const uint32_t above_even = uint32_t(kColumns * ((light.count + 1) / 2)) - preset_even[lane];
    const uint32_t above_odd = uint32_t(kColumns * (light.count / 2)) - preset_odd[lane];
    const uint32_t hidden_even = even[lane] - preset_even[lane], hidden_odd = odd[lane] - preset_odd[lane];
    const uint32_t above = above_even + above_odd;
    if (const uint32_t asked = tosses.asked[lane]; asked > 0 && above > 0) {
      const float hid = float(tosses.hid[lane]), seen = float(asked) - hid;
      result->coin_error[i] = kErrorOfDeviation * std::sqrt(hid * seen / float(asked)) / float(above);
    }
    result->hidden[i] = above == 0 ? 1 : float(hidden_even + hidden_odd) / float(above);
    if (above_even == 0 || above_odd == 0) continue;
    result->disagreement[i] = std::abs(float(hidden_even) / float(above_even) - float(hidden_odd) / float(above_odd));
  }
}

// What a level of a mesh may show on the light, of its edge and times the rows: a 67th at 16. Levels are mostly off by
// less than their bound. S6 in the accuracy tests: .00090 up to here as without levels, .00094 at a fiftieth.
constexpr float kLevelErrorOfOneRow = 0.24f;

// From R / 8 to 5 R / 16 rows, up or down. Over edges of all directions 16 rows then err by .0019 on average and by
// .003 in the worst one; when all leant by one row, by .0029 and .014.
int LeanOf(uint32_t hash, int rows) {
  const int least = HWY_MAX(1, rows / 8), most = rows * 5 / 16;
  const int lean = least + int((hash >> 1) % uint32_t(most - least + 1));
  return (hash & 1) != 0 ? lean : -lean;
}

void ResolveTileHere(const PolygonTree& tree, const std::vector<RayMask>& masks, const Tile& tile, int rows,
                     TileScratch* lists, TileResult* result) {
  std::fill_n(result->hidden, Tile::kMost, 0.0f);
  std::fill_n(result->disagreement, Tile::kMost, 0.0f);
  std::fill_n(result->coin_error, Tile::kMost, 0.0f);
  const Bounds bounds = BoundsOf(tile, 0, Tile::kBlocks);
  FindPolygons(tree, MakeShaft(tile, 0, tile.shares_one_plane ? Tile::kBlocks : 0, bounds), bounds,
               kLevelErrorOfOneRow / float(rows), lists);
  result->polygons = uint32_t(lists->tile.size());
  result->drawn = 0;
  if (lists->tile.empty()) return;
  Arrange(lists->tile, bounds, &lists->arranged);

  float row_shift[kMostRows];  // van der Corput's
  for (int r = 0; r < rows; ++r) {
    uint32_t reversed = 0;
    for (int bit = 1; bit < rows; bit *= 2) reversed = 2 * reversed + ((r & bit) != 0 ? 1 : 0);
    row_shift[r] = (float(reversed) + 0.5f) / float(rows);
  }
  LightRows light;
  for (int block = 0; block < Tile::kBlocks; ++block) {
    if (tile.active[block] == 0) continue;
    const Bounds block_bounds = BoundsOf(tile, block, block + 1);
    const Shaft shaft = MakeShaft(tile, block, tile.shares_plane[block] ? block + 1 : block, block_bounds);
    NarrowList(lists->tile, lists->arranged, shaft, block_bounds, &lists->block);
    if (lists->block.empty()) continue;
    StartRows(tile, block, rows, LeanOf(tile.block_hash[block], rows), row_shift, &light);
    Tosses tosses;
    result->drawn += DrawList(tree, masks, *lists, tile, block, &light, &tosses);
    CountHidden(light, tile, block, tosses, result);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace halfshade
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace halfshade {

HWY_EXPORT(ResolveTileHere);

void ResolveTile(const PolygonTree& tree, const std::vector<RayMask>& masks, const Tile& tile, int rows,
                 TileScratch* scratch, TileResult* result) {
  HWY_DYNAMIC_DISPATCH(ResolveTileHere)(tree, masks, tile, rows, scratch, result);
}

}  // namespace halfshade
#endif
