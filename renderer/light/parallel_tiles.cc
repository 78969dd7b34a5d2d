#include "renderer/light/parallel_tiles.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>

#include "renderer/gl/context.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr double kRunMs = 10;
constexpr int kFirstRun = 64;

}  // namespace

absl::Status ForEachTile(int count, const std::function<void(int)>& work, const std::function<absl::Status()>& stop) {
  using Clock = std::chrono::steady_clock;
  tbb::task_arena arena(gl::AvailableCpus());
  int run = kFirstRun;
  for (int first = 0; first < count;) {
    RETURN_IF_ERROR(stop());
    const int last = std::min(count, first + run);
    const Clock::time_point begin = Clock::now();
    arena.execute([&] {
      tbb::parallel_for(tbb::blocked_range<int>(first, last), [&](const tbb::blocked_range<int>& range) {
        for (int tile = range.begin(); tile < range.end(); ++tile) work(tile);
      });
    });
    const double elapsed_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    first = last;
    run = std::max(1, int(double(run) * std::clamp(kRunMs / std::max(elapsed_ms, 1e-3), 0.1, 4.0)));
  }
  return absl::OkStatus();
}

}  // namespace halfshade
