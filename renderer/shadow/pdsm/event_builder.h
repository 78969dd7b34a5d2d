// Exact attenuation functions from the events of sample maps, one map after the other.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "renderer/shadow/pdsm/attenuation.h"
#include "renderer/shadow/pdsm/pdsm_grid.h"

namespace halfshade::pdsm {

enum class EventForm : uint8_t { kTraversal, kScatter };

// How exact functions become the ones that are kept.
struct Finishing {
  float eps = 0;                 // as Compress
  bool is_surface_only = false;  // eps holds where a map shows a surface on the ray, in light, in umbra and behind them
  // Asked between chunks of rows, on the calling thread; not OK: Finish returns it. Null: nobody asks.
  std::function<absl::Status()> stop = nullptr;
};

// All rows, made on TBB's threads.
absl::StatusOr<AttenuationFunctions> FinishRows(int size, const std::function<absl::Status()>& stop,
                                                const std::function<void(int row, FunctionRow* out)>& make_row);
absl::Status TooManyEvents(uint64_t events, int maps, uint64_t max_events);

// Holds 8 bytes an event. Runs on TBB's threads; the functions do not depend on them.
class EventBuilder {
 public:
  static constexpr uint64_t kMaxEvents = 128ull << 20;
  EventBuilder(const Grid& grid, EventForm form, uint64_t max_events = kMaxEvents);
  ~EventBuilder();

  // Adds the events of one map. RESOURCE_EXHAUSTED, with the figures, over max_events of all maps.
  absl::Status Add(const SampleMap& map);

  struct Result {
    AttenuationFunctions functions;
    FunctionCounts raw;  // events before compression
  };
  // Each event is 1 / (the number of maps). Events of one depth merge. The builder is empty then.
  absl::StatusOr<Result> Finish(const Finishing& finishing);

 private:
  struct Rows;
  const Grid grid_;
  const EventForm form_;
  const uint64_t max_events_;
  int maps_ = 0;
  std::unique_ptr<Rows> rows_;
};

}  // namespace halfshade::pdsm
