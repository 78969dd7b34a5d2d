#include "renderer/light/depth_tables.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>
#include <vector>

#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr int kRowsBetweenStops = 64;
constexpr float kLeastRange = 1.0f / (1 << 20);

}  // namespace

absl::StatusOr<DepthTables> BuildDepthTables(const float* depths, int size, int texels_per_patch, int slabs,
                                             const std::function<absl::Status()>& stop) {
  assert(size >= 1 && size <= DepthTables::kMaxSize && slabs >= 1 && slabs <= DepthTables::kMaxSlabs);
  const int side = size * texels_per_patch;
  DepthTables tables;
  tables.size = size;
  tables.slabs = slabs;
  float furthest = 1;
  for (const float depth : std::span(depths, size_t(side) * side)) {
    tables.nearest_depth = std::max(tables.nearest_depth, depth);
    furthest = std::min(furthest, depth > 0 ? depth : 1.0f);
  }
  tables.first_depth = furthest;
  tables.slab_depth = std::max(tables.nearest_depth - furthest, kLeastRange * furthest) / float(slabs);
  tables.slabs_per_depth = 1 / tables.slab_depth;

  const int entry = tables.entry = DepthTables::EntryOf(slabs);
  tables.sums = std::make_unique_for_overwrite<uint32_t[]>(tables.SizeBytes() / sizeof(uint32_t));
  std::fill_n(tables.sums.get(), size_t(size + 1) * entry, 0u);
  const uint32_t texel_area = DepthTables::kFullPatch / uint32_t(texels_per_patch * texels_per_patch);
  std::vector<uint32_t> row(size_t(size) * entry);
  for (int y = 0; y < size; ++y) {
    if (y % kRowsBetweenStops == 0) RETURN_IF_ERROR(stop());
    std::fill(row.begin(), row.end(), 0);
    for (int line = y * texels_per_patch; line < (y + 1) * texels_per_patch; ++line) {
      const float* texel = &depths[size_t(line) * side];
      for (int x = 0; x < size; ++x) {
        uint32_t* patch = &row[size_t(x) * entry];
        for (int i = 0; i < texels_per_patch; ++i, ++texel) {
          if (*texel == 0) continue;
          const float place = tables.PlaceOf(*texel);
          const int slab = std::min(int(place), slabs - 1);
          patch[slab] += texel_area;
          patch[slabs + slab] +=
              uint32_t(DepthTables::kPlaces * float(texel_area) * std::min(place - float(slab), 1.0f) + 0.5f);
        }
      }
    }
    uint32_t running[DepthTables::EntryOf(DepthTables::kMaxSlabs)] = {};
    const uint32_t* above = &tables.sums[size_t(y) * (size + 1) * entry];
    uint32_t* sums = &tables.sums[size_t(y + 1) * (size + 1) * entry];
    std::fill_n(sums, entry, 0u);
    for (int x = 0; x < size; ++x) {
      uint32_t* patch = &row[size_t(x) * entry];
      for (int slab = slabs - 1; slab > 0; --slab) patch[slab - 1] += patch[slab];
      above += entry;
      sums += entry;
      for (int i = 0; i < entry; ++i) {
        running[i] += patch[i];
        sums[i] = running[i] + above[i];
      }
    }
  }
  return tables;
}

}  // namespace halfshade
