#include "renderer/light/parallel_for.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

TEST(ParallelForTest, EachIsDoneOnce) {
  for (const int grain : {1, 7, 5000, 9999}) {
    for (const int threads : {0, 1, 3}) {
      std::vector<std::atomic<int>> done(5000);
      EXPECT_OK(ParallelFor(
          int(done.size()), grain, [&](int i) { ++done[size_t(i)]; }, [] { return absl::OkStatus(); }, threads));
      for (const auto& times : done) EXPECT_EQ(times, 1);
    }
  }
  EXPECT_OK(ParallelFor(
      0, 1, [](int) { FAIL(); }, [] { return absl::OkStatus(); }));
}

// A million light ones, as tiles that nothing shades, and then heavy ones.
TEST(ParallelForTest, StopIsAskedAmongHeavyOnesAfterLightOnes) {
  constexpr int kLight = 1 << 20, kHeavy = 1000;
  std::atomic<int> heavy = 0;
  int asked = 0, asked_among_heavy = 0;
  const absl::Status status = ParallelFor(
      kLight + kHeavy, 1,
      [&](int i) {
        if (i < kLight) return;
        ++heavy;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      },
      [&] {
        ++asked;
        asked_among_heavy += heavy > 0 ? 1 : 0;
        return asked_among_heavy > 2 ? absl::CancelledError("enough") : absl::OkStatus();
      },
      2);
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
  EXPECT_GE(heavy, 3);
  EXPECT_LE(heavy, 2 * 3 * 3) << "a thread does three at most in each of 10 ms";
}

}  // namespace
}  // namespace halfshade
