#include "renderer/light/parallel_tiles.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

TEST(ForEachTileTest, EachTileIsDoneOnce) {
  std::vector<std::atomic<int>> done(5000);
  EXPECT_OK(ForEachTile(
      int(done.size()), [&](int i) { ++done[size_t(i)]; }, [] { return absl::OkStatus(); }));
  for (const auto& times : done) EXPECT_EQ(times, 1);
  EXPECT_OK(ForEachTile(
      0, [](int) { FAIL(); }, [] { return absl::OkStatus(); }));
}

TEST(ForEachTileTest, StopEndsItWithinAFewRuns) {
  std::atomic<int> done = 0;
  int asked = 0;
  const absl::Status status = ForEachTile(
      1 << 20,
      [&](int) {
        ++done;
        std::this_thread::sleep_for(std::chrono::microseconds(100));
      },
      [&] { return ++asked > 2 ? absl::CancelledError("enough") : absl::OkStatus(); });
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(asked, 3);
  EXPECT_LT(done, 64 + 4 * 64 + 1);  // a run is at most four times the one before
}

}  // namespace
}  // namespace halfshade
