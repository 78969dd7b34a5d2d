#include "server/call_time.h"

#include <time.h>

#include <algorithm>

namespace halfshade {
namespace {

constexpr auto kDefaultDeadline = std::chrono::seconds(30);
constexpr auto kMaxDeadline = std::chrono::minutes(10);

}  // namespace

std::chrono::system_clock::time_point EffectiveDeadline(std::chrono::system_clock::time_point asked) {
  using SystemClock = std::chrono::system_clock;
  const auto now = SystemClock::now();
  // gRPC's "never" comes as the largest time point, or as one that is nearly as far.
  if (asked > now + std::chrono::hours(24 * 365)) return now + kDefaultDeadline;
  return std::min<SystemClock::time_point>(asked, now + kMaxDeadline);
}

double ProcessCpuMs() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) * 1e3 + double(time.tv_nsec) * 1e-6;
}

}  // namespace halfshade
