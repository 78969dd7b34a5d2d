#include <gtest/gtest.h>

#include <cstdio>

#include "renderer/calibrate.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

TEST(CalibrateTest, TellsAMachinesPaceAndLeavesNothingBehind) {
  const auto bytes = [] {
    uint64_t sum = 0;
    for (const CacheReport& cache : TestRenderer().Caches()) sum += cache.bytes;
    return sum;
  };
  const uint64_t before = bytes();
  const auto slowness = MeasureSlowness(TestRenderer());
  ASSERT_OK(slowness);
  std::printf("slowness %.3f\n", *slowness);
  EXPECT_GT(*slowness, 1.0 / 16) << "nothing draws it in a third of a millisecond";
  EXPECT_LE(*slowness, 64) << "which sanitizers reach";
  EXPECT_EQ(bytes(), before);
}

}  // namespace
}  // namespace halfshade
