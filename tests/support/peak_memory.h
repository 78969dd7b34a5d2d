// The most memory that this process has had in RAM, and a way to begin anew. Linux. One at a time in a process.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>

namespace halfshade {

// Since the process began, or since the last call of ForgetPeak.
inline uint64_t OwnPeakBytes() {
  std::ifstream status("/proc/self/status");
  uint64_t kib = 0;
  for (std::string word; status >> word;) {
    if (word == "VmHWM:") status >> kib;
  }
  return kib << 10;
}

inline void ForgetPeak() { std::ofstream("/proc/self/clear_refs") << 5; }

}  // namespace halfshade
