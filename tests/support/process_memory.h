// What this process has in RAM, and the most that it had. Linux.
#pragma once

#include <malloc.h>

#include <cstdint>
#include <fstream>
#include <string>

// jemalloc's, where the program has it.
extern "C" int mallctl(const char* name, void* old, size_t* old_size, void* value, size_t size) __attribute__((weak));

namespace halfshade {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kIsPlainMemory = false;  // what is freed is kept for a while: its growth says nothing
#else
inline constexpr bool kIsPlainMemory = true;
#endif

inline double ResidentMb() {
  double pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * 4096 / 1e6;
}

// Since the process began, or since the last call of ForgetPeak. One asks at a time.
inline uint64_t OwnPeakBytes() {
  std::ifstream status("/proc/self/status");
  uint64_t kib = 0;
  for (std::string word; status >> word;) {
    if (word == "VmHWM:") status >> kib;
  }
  return kib << 10;
}

inline void ForgetPeak() { std::ofstream("/proc/self/clear_refs") << 5; }

// Freed memory goes back to the system now, not in a second.
inline void PurgeFreedMemory() {
  malloc_trim(0);
  if (mallctl == nullptr) return;
  mallctl("thread.tcache.flush", nullptr, nullptr, nullptr, 0);
  mallctl("arena.4096.purge", nullptr, nullptr, nullptr, 0);  // MALLCTL_ARENAS_ALL
}

}  // namespace halfshade
