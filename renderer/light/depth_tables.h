// Depth-binned summed-area tables of one map: how much of any rectangle is covered, by depths, from four corners.
//
// Depth is w z_near, as maps store it; 0 is empty. [nearest, furthest] of what a map shows is cut into `slabs` of equal
// depth. A table sums patches of `texels_per_patch`^2 texels: covered area, and where in its slab that is. So a
// rectangle gives the covered share of every slab and its mean depth there, whatever its size. This is Soler and
// Sillion's convolution (1998), a slab at a time. Sums are integers and wrap: what comes out of a rectangle is exact.
// Pure; no GL.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace halfshade {

struct DepthTables {
  static constexpr uint32_t kFullPatch = 256;  // covered area of a patch
  static constexpr float kPlaces = 16;         // of a slab, in its moment
  static constexpr int kMaxSlabs = 16;
  static constexpr int kMaxSize = 1024;  // patches a side: 2^20 of them, of at most 2^12, are less than 2^32

  int size = 0;           // patches a side
  int slabs = 0;          // slab k holds depths from first_depth + k slab_depth
  float first_depth = 0;  // the furthest that is shown
  float slab_depth = 0;   // over 0
  float slabs_per_depth = 0;
  float nearest_depth = 0;  // 0: nothing is shown
  // [size + 1][size + 1][entry]: over all patches above and to the left, first the area of slab k and all nearer ones,
  // then of slab k alone the sum of kPlaces (place in the slab, 0..1) (area), then zeros up to a whole vector.
  std::unique_ptr<uint32_t[]> sums;
  int entry = 0;

  bool IsEmpty() const { return nearest_depth == 0; }
  // Which slab holds a depth that is shown: the whole part of this, at most slabs - 1.
  float PlaceOf(float depth) const { return (depth - first_depth) * slabs_per_depth; }
  float SlabStart(int slab) const { return first_depth + float(slab) * slab_depth; }
  const uint32_t* At(int x, int y) const { return &sums[(size_t(y) * (size + 1) + x) * entry]; }
  uint64_t SizeBytes() const { return SizeBytes(size, slabs); }
  static constexpr int EntryOf(int slabs) { return (2 * slabs + 3) / 4 * 4; }
  static uint64_t SizeBytes(int size, int slabs) { return 4ull * EntryOf(slabs) * (size + 1) * (size + 1); }
};

// `depths`: [size texels_per_patch]^2, each in [0,1]. texels_per_patch is 1, 2 or 4; 1 <= slabs <= kMaxSlabs;
// 1 <= size <= kMaxSize (asserted). `stop` is asked a few times; its error comes back.
absl::StatusOr<DepthTables> BuildDepthTables(
    const float* depths, int size, int texels_per_patch, int slabs,
    const std::function<absl::Status()>& stop = [] { return absl::OkStatus(); });

}  // namespace halfshade
