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
#include "renderer/status.h"

namespace halfshade::pdsm {
namespace {

constexpr int kRowsPerTask = 16;
constexpr int kRowsPerChunk = 64;  // some ten milliseconds
constexpr uint32_t kBitsOfOne = std::bit_cast<uint32_t>(1.0f);

// Depth, sign and kind of an event, rising from the light outward; at one depth surfaces first, then entries. Depths
// are in (0, 1].
uint32_t KeyOf(float depth, bool is_entry, EventKind kind) {
  return (kBitsOfOne - std::bit_cast<uint32_t>(depth)) << 2 | uint32_t(!is_entry) << 1 | uint32_t(kind);
}
uint32_t DepthKeyOf(uint32_t key) { return key >> 2; }
float DepthOf(uint32_t key) { return std::bit_cast<float>(kBitsOfOne - DepthKeyOf(key)); }
int SignOf(uint32_t key) { return (key & 2) == 0 ? 1 : -1; }
bool IsTop(uint32_t key) { return EventKind(key & 1) == EventKind::kTop; }

struct ColumnEvent {
  uint32_t column = 0;
  uint32_t key = 0;
};

// Sorted events -> the exact step function; or, of surfaces only, its steps at surfaces, from and to light and umbra,
// and all behind the last surface: what receives there does not cast.
void MakeSteps(const std::vector<uint32_t>& keys, size_t begin, size_t end, int maps, bool is_surface_only,
               std::vector<Vertex>* steps) {
  steps->clear();
  int hidden = 0;
  size_t last_surface = begin;
  for (size_t i = begin; i < end && is_surface_only; ++i) {
    if (IsTop(keys[i])) last_surface = i;
  }
  for (size_t i = begin; i < end;) {
    const uint32_t depth_key = DepthKeyOf(keys[i]);
    const int before = hidden;
    const float depth = DepthOf(keys[i]);
    bool is_kept = !is_surface_only || i >= last_surface;
    for (; i < end && DepthKeyOf(keys[i]) == depth_key; ++i) {
      hidden += SignOf(keys[i]);
      is_kept |= IsTop(keys[i]);
    }
    if (hidden == before) {
      // Nothing changes at the surface, but its value is to be kept.
      if (is_surface_only && is_kept) steps->push_back({depth, float(hidden) / float(maps)});
      continue;
    }
    is_kept |= before == 0 || before == maps || hidden == 0 || hidden == maps;
    if (!is_kept) continue;
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
      lists[event.ray.y].push_back({uint32_t(event.ray.x), KeyOf(event.depth, event.is_entry, event.kind)});
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
    return TooManyEvents(rows_->events, maps_, max_events_);
  }
  return absl::OkStatus();
}

absl::Status TooManyEvents(uint64_t events, int maps, uint64_t max_events) {
  return absl::ResourceExhaustedError("pdsm: " + std::to_string(events) + " events of " + std::to_string(maps) +
                                      " maps; at most " + std::to_string(max_events) +
                                      "; construction SLICES has no such bound");
}

absl::StatusOr<AttenuationFunctions> FinishRows(int size, const std::function<absl::Status()>& stop,
                                                const std::function<void(int row, FunctionRow* out)>& make_row) {
  std::vector<FunctionRow> rows(size);
  for (int chunk = 0; chunk < size; chunk += kRowsPerChunk) {
    if (stop) RETURN_IF_ERROR(stop());
    tbb::parallel_for(chunk, std::min(size, chunk + kRowsPerChunk), [&](int row) { make_row(row, &rows[row]); });
  }
  return JoinRows(rows);
}

absl::StatusOr<EventBuilder::Result> EventBuilder::Finish(const Finishing& finishing) {
  const int size = grid_.size;
  std::vector<uint32_t> most(size);
  const auto make_row = [&](int row, FunctionRow* out) {
    // Counting sort by column.
    std::vector<uint32_t> keys, ends(size_t(size) + 1);
    for (const Rows::Lists& lists : rows_->lists) {
      for (const ColumnEvent& event : lists[row]) ++ends[event.column + 1];
    }
    for (int x = 0; x < size; ++x) ends[x + 1] += ends[x];
    keys.resize(ends[size]);
    for (Rows::Lists& lists : rows_->lists) {
      for (const ColumnEvent& event : lists[row]) keys[ends[event.column]++] = event.key;
      lists[row] = {};
    }
    std::vector<Vertex> steps;
    uint32_t begin = 0;
    for (int x = 0; x < size; ++x) {
      const uint32_t end = ends[x];
      SortKeys(keys.data() + begin, end - begin);
      most[row] = std::max(most[row], end - begin);
      MakeSteps(keys, begin, end, maps_, finishing.is_surface_only, &steps);
      out->Add(steps, finishing.eps);
      begin = end;
    }
  };
  Result result;
  ASSIGN_OR_RETURN(result.functions, FinishRows(size, finishing.stop, make_row));
  result.raw.mean = double(rows_->events) / double(grid_.RayCount());
  result.raw.most = *std::max_element(most.begin(), most.end());
  rows_ = std::make_unique<Rows>(size);
  maps_ = 0;
  return result;
}

}  // namespace halfshade::pdsm
