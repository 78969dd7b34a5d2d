#include "renderer/shadow/pdsm/slice_builder.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "renderer/shadow/pdsm/count_above.h"

namespace halfshade::pdsm {
namespace {

constexpr int kMapsAtOnce = 8;  // their buckets, 2 MB at 512^2, stay in the second cache; at most 255

int FloorDivide(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

// How many of the depths a texel of `depth` hides: those below it.
uint8_t BucketOf(const std::vector<float>& depths, float depth) {
  return uint8_t(std::lower_bound(depths.begin(), depths.end(), depth) - depths.begin());
}

}  // namespace

std::vector<float> SliceSpacing::Depths() const {
  std::vector<float> depths(count);
  for (int i = 0; i < behind; ++i) {
    const float left = 1 - float(i) / float(behind);
    depths[i] = occluders_from * (1 - left * left);
  }
  const int steps = count - 1 - behind;
  for (int i = 0; i <= steps; ++i) {
    depths[behind + i] = occluders_from + (1 - occluders_from) * float(i) / float(steps);
  }
  depths.back() = 1;
  return depths;
}

SliceSpacing SpaceSlices(int count, double farthest_occluder_depth) {
  // Of leaves (S5) 4 to 12 serve about alike.
  constexpr double kFinerAmongOccluders = 7;
  SliceSpacing spacing;
  spacing.count = count;
  // Neither part is empty.
  spacing.occluders_from = float(std::clamp(farthest_occluder_depth, 1.0 / 64, 63.0 / 64));
  const double behind = spacing.occluders_from;
  const double share = behind / (behind + kFinerAmongOccluders * (1 - behind));
  // At least eight: what receives behind a room's occluders, or a plate's, asks them.
  spacing.behind = std::clamp(int(std::lround(share * (count - 1))), std::min(8, count - 2), count - 2);
  return spacing;
}

SliceBuilder::SliceBuilder(const Grid& grid, std::vector<float> depths) : grid_(grid) {
  assert(!depths.empty() && depths.size() <= 255);
  volume_.size = grid.size;
  volume_.depths = std::move(depths);
  volume_.counts.resize(volume_.depths.size() * grid.RayCount());
  plane_side_ = (grid.map_size + grid.map_texels - 1) / grid.map_texels;
  stride_ = plane_side_ + int(kCountPadding);
}

void SliceBuilder::Add(const SampleMap& map) {
  const int planes_a_side = grid_.map_texels;
  Buckets& buckets = pending_.emplace_back();
  const size_t plane_bytes = size_t(stride_) * plane_side_;
  buckets.values.assign(plane_bytes * planes_a_side * planes_a_side + kCountPadding, 0);
  // A guess that is never too high, then the exact comparison.
  constexpr int kGuesses = 1024;
  std::vector<uint8_t> guesses(kGuesses + 1);
  for (int i = 0; i <= kGuesses; ++i) guesses[i] = BucketOf(volume_.depths, float(i) / kGuesses);
  const size_t slices = volume_.depths.size();
  tbb::parallel_for(tbb::blocked_range<int>(0, grid_.map_size, 32), [&](const tbb::blocked_range<int>& range) {
    for (int y = range.begin(); y < range.end(); ++y) {
      for (int x = 0; x < grid_.map_size; ++x) {
        const float depth = map.depths[size_t(y) * grid_.map_size + x];
        if (depth <= 0) continue;
        size_t bucket = guesses[int(depth * kGuesses)];
        while (bucket < slices && volume_.depths[bucket] < depth) ++bucket;
        const int plane = y % planes_a_side * planes_a_side + x % planes_a_side;
        buckets.values[plane * plane_bytes + size_t(y / planes_a_side) * stride_ + x / planes_a_side] = uint8_t(bucket);
      }
    }
  });
  const SamplePath path = MakePath(grid_, map.point, map.corner);
  for (const float depth : volume_.depths) {
    // At 0 the last step goes on.
    buckets.cells.push_back(path.steps[depth > 0 ? path.StepAt(depth) : path.steps.size() - 1].cell);
  }
  ++volume_.maps;
  if (pending_.size() == kMapsAtOnce) AddPending();
}

void SliceBuilder::AddPending() {
  const int size = grid_.size;
  const int ratio = grid_.map_texels;
  const size_t plane_bytes = size_t(stride_) * plane_side_;
  const int slices = int(volume_.depths.size());
  tbb::parallel_for(tbb::blocked_range<int>(0, size, 8), [&](const tbb::blocked_range<int>& range) {
    std::vector<uint8_t> hidden(size + kCountPadding), beyond(size + kCountPadding);
    for (int slice = 0; slice < slices; ++slice) {
      for (int row = range.begin(); row < range.end(); ++row) {
        std::fill(hidden.begin(), hidden.end(), uint8_t(0));
        std::fill(beyond.begin(), beyond.end(), uint8_t(0));
        for (const Buckets& buckets : pending_) {
          // Texel cell + ratio (column, row) is one of plane cell mod ratio, at cell / ratio + (column, row).
          const glm::ivec2 cell = buckets.cells[slice];
          const glm::ivec2 shift(FloorDivide(cell.x, ratio), FloorDivide(cell.y, ratio));
          const glm::ivec2 offset = cell - shift * ratio;
          const int y = row + shift.y;
          const int first = std::max(0, -shift.x);
          const int end = std::min(size, plane_side_ - shift.x);
          if (y < 0 || y >= plane_side_ || first >= end) continue;
          const uint8_t* texels = &buckets.values[(offset.y * ratio + offset.x) * plane_bytes + size_t(y) * stride_];
          CountAbove(texels + first + shift.x, uint8_t(slice), end - first, &hidden[first]);
          CountAbove(texels + first + shift.x, uint8_t(slice + 1), end - first, &beyond[first]);
        }
        SliceCounts* counts = &volume_.counts[(size_t(slice) * size + row) * size];
        for (int x = 0; x < size; ++x) {
          counts[x].hidden = uint16_t(counts[x].hidden + hidden[x]);
          counts[x].hidden_from_beyond = uint16_t(counts[x].hidden_from_beyond + beyond[x]);
        }
      }
    }
  });
  pending_.clear();
}

SliceVolume SliceBuilder::Finish() {
  AddPending();
  return std::move(volume_);
}

}  // namespace halfshade::pdsm
