// The hidden part of the light at a tile of receivers: a shaft's list of polygons, drawn as bits.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/ray_mask.h"
#include "renderer/shadow/shaft/polygon_tree.h"
#include "renderer/shadow/shaft/tile.h"

namespace halfshade {

// What a tile's resolve leaves.
struct TileResult {
  float hidden[Tile::kMost];  // fraction of the light's part above the receiver's plane, in [0,1]
  // |even rows' hidden fraction - odd rows'|, what the samples may be off by; 0 where not active.
  float disagreement[Tile::kMost];
  float coin_error[Tile::kMost];  // expected |error| of hidden by the samples that BLEND tossed coins for
  uint32_t polygons = 0;          // in the tile's list; none: the tile is lit, exactly
  uint64_t drawn = 0;             // polygons of all blocks' lists
};

// Lists that grow once a thread.
struct TileScratch {
  std::vector<uint32_t> stack, instances;
  std::vector<Polygon> tile;
  std::vector<uint32_t> block;  // into tile
  std::vector<Polygons16> arranged;
};

// `rows`: 4, 8, 16, 32 or 64, of 32 samples each. `masks`: of PolygonTree::masked. Of lanes that are not active the
// result is 0. The same bytes on every instruction set (Highway's dispatch). Any thread, with a scratch of its own.
void ResolveTile(const PolygonTree& tree, const std::vector<RayMask>& masks, const Tile& tile, int rows,
                 TileScratch* scratch, TileResult* result);

}  // namespace halfshade
