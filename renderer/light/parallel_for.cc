#include "renderer/light/parallel_for.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

#include "renderer/gl/context.h"
#include "renderer/gl/turn.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr std::chrono::milliseconds kStopPeriod{10};

}  // namespace

absl::Status ParallelFor(int count, int grain, const std::function<void(int)>& work,
                         const std::function<absl::Status()>& stop, int threads) {
  using Clock = std::chrono::steady_clock;
  tbb::task_arena arena(threads > 0 ? threads : gl::AvailableCpus());
  std::atomic<int64_t> next = 0;
  std::optional<gl::TurnPause> pause;  // once what GL had under way is finished
  while (next < count) {
    RETURN_IF_ERROR(stop());
    if (!pause) pause.emplace();
    const Clock::time_point end = Clock::now() + kStopPeriod;
    // Not sized by what the last ones took: work that follows on light work may be a thousand times heavier.
    const auto work_until_end = [&](int) {
      while (Clock::now() < end) {
        const int64_t first = next.fetch_add(grain);
        for (int64_t i = first; i < std::min<int64_t>(count, first + grain); ++i) work(int(i));
        if (first + grain >= count) break;
      }
    };
    arena.execute([&] { tbb::parallel_for(0, arena.max_concurrency(), work_until_end); });
  }
  return absl::OkStatus();
}

}  // namespace halfshade
