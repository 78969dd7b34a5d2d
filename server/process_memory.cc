#include "server/process_memory.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <mutex>

namespace halfshade {
namespace {

using Clock = std::chrono::steady_clock;

// What a picture takes anew when its memory was given back is its pages' faults: of 64 MB some 10 ms, so not for each.
constexpr std::chrono::seconds kPause(1);
constexpr uint64_t kSlackBytes = 32ull << 20;

}  // namespace

uint64_t ResidentBytes() {
  uint64_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * uint64_t(sysconf(_SC_PAGESIZE));
}

void ReturnFreedMemory() {
  static std::mutex mutex;
  static Clock::time_point last;
  static uint64_t resident_then = 0;  // or the least since
  const std::unique_lock lock(mutex, std::try_to_lock);
  if (!lock || Clock::now() < last + kPause) return;
  const uint64_t resident = ResidentBytes();
  resident_then = std::min(resident_then, resident);
  if (resident < resident_then + kSlackBytes) return;
  malloc_trim(0);
  last = Clock::now();
  resident_then = ResidentBytes();
}

}  // namespace halfshade
