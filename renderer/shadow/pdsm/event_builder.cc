#include "renderer/shadow/pdsm/event_builder.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <string>

#include "renderer/shadow/pdsm/events.h"
#include "renderer/shadow/pdsm/sort_keys.h"

namespace halfshade::pdsm {
namespace {

constexpr int kRowsPerTask = 16;
constexpr uint32_t kBitsOfOne = std::bit_cast<uint32_t>(1.0f);

// Depth and sign of an event, rising from the light outward; at one depth entries first. Depths are in (0, 1].
uint32_t KeyOf(float depth, bool is_entry) {
  return (kBitsOfOne - std::bit_cast<uint32_t>(depth)) << 1 | uint32_t(!is_entry);
}
float DepthOf(uint32_t key) { return std::bit_cast<float>(kBitsOfOne - (key >> 1)); }
int SignOf(uint32_t key) { return (key & 1) == 0 ? 1 : -1; }

struct ColumnEvent {
  uint32_t column = 0;
  uint32_t key = 0;
};

// Sorted events -> the exact step function.
void MakeSteps(const std::vector<uint32_t>& keys, size_t begin, size_t end, int maps, std::vector<Vertex>* steps) {
  steps->clear();
  int hidden = 0;
  for (size_t i = begin; i < end;) {
    const uint32_t depth_key = keys[i] >> 1;
    const int before = hidden;
    const float depth = DepthOf(keys[i]);
    for (; i < end && keys[i] >> 1 == depth_key; ++i) hidden += SignOf(keys[i]);
    if (hidden == before) continue;
    steps->push_back({depth, float(before) / float(maps)});
    steps->push_back({depth, float(hidden) / float(maps)});
  }
}

}  // namespace

// [row of the PDSM] of each thread: sorted at the end, so that threads leave no trace.
struct EventBuilder::Rows {
  using Lists = std::vector<std::vector<ColumnEvent>>;
  explicit Rows(int size) : lists(Lists(size)) {}
  tbb::enumerable_thread_specific<Lists> lists;
  std::atomic<uint64_t> events{0};
};

EventBuilder::EventBuilder(const Grid& grid, EventForm form, uint64_t max_events)
    : grid_(grid), form_(form), max_events_(max_events), rows_(std::make_unique<Rows>(grid.size)) {}
EventBuilder::~EventBuilder() = default;

absl::Status EventBuilder::Add(const SampleMap& map) {
  ++maps_;
  const SamplePath path = MakePath(grid_, map.point, map.corner);
  const bool traverses = form_ == EventForm::kTraversal;
  const TexelSteps steps(grid_, map, path);
  const int rows = traverses ? grid_.size : grid_.map_size + 1;
  tbb::parallel_for(tbb::blocked_range<int>(0, rows, kRowsPerTask), [&](const tbb::blocked_range<int>& range) {
    Rows::Lists& lists = rows_->lists.local();
    uint64_t count = 0;
    const auto emit = [&](const Event& event) {
      lists[event.ray.y].push_back({uint32_t(event.ray.x), KeyOf(event.depth, event.is_entry)});
      ++count;
    };
    for (int row = range.begin(); row < range.end(); ++row) {
      if (traverses) {
        TraverseRow(grid_, map, path, row, emit);
      } else {
        steps.ScatterRow(row, emit);
      }
    }
    rows_->events += count;
  });
  if (rows_->events > max_events_) {
    return absl::ResourceExhaustedError("pdsm: " + std::to_string(rows_->events) + " events of " +
                                        std::to_string(maps_) + " maps; at most " + std::to_string(max_events_) +
                                        "; construction SLICES has no such bound");
  }
  return absl::OkStatus();
}

EventBuilder::Result EventBuilder::Finish(float eps) {
  Result result;
  const int size = grid_.size;
  std::vector<std::vector<Vertex>> vertices(size);
  std::vector<uint32_t> counts(grid_.RayCount());
  std::vector<uint32_t> most(size);
  tbb::parallel_for(tbb::blocked_range<int>(0, size), [&](const tbb::blocked_range<int>& range) {
    std::vector<uint32_t> keys, ends;
    std::vector<Vertex> steps;
    for (int row = range.begin(); row < range.end(); ++row) {
      // Counting sort by column.
      ends.assign(size_t(size) + 1, 0);
      for (const Rows::Lists& lists : rows_->lists) {
        for (const ColumnEvent& event : lists[row]) ++ends[event.column + 1];
      }
      for (int x = 0; x < size; ++x) ends[x + 1] += ends[x];
      keys.resize(ends[size]);
      for (Rows::Lists& lists : rows_->lists) {
        for (const ColumnEvent& event : lists[row]) keys[ends[event.column]++] = event.key;
        lists[row] = {};
      }
      uint32_t begin = 0;
      for (int x = 0; x < size; ++x) {
        const uint32_t end = ends[x];
        SortKeys(keys.data() + begin, end - begin);
        most[row] = std::max(most[row], end - begin);
        MakeSteps(keys, begin, end, maps_, &steps);
        const size_t first = vertices[row].size();
        if (!steps.empty()) Compress(steps, eps, &vertices[row]);
        counts[size_t(row) * size + x] = uint32_t(vertices[row].size() - first);
        begin = end;
      }
    }
  });
  result.raw.mean = double(rows_->events) / double(grid_.RayCount());
  result.raw.most = *std::max_element(most.begin(), most.end());
  result.functions = JoinRows(size, counts, vertices);
  rows_ = std::make_unique<Rows>(size);
  maps_ = 0;
  return result;
}

}  // namespace halfshade::pdsm
