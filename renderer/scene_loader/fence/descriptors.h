// Whole reads and writes of a descriptor, by read and write alone.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>

namespace halfshade {

inline constexpr size_t kBytesPerCall = 1 << 30;  // the system takes no more than 2 GiB at a time

inline bool ReadWhole(int file, void* bytes, size_t size) {
  for (char* at = static_cast<char*>(bytes); size > 0;) {
    const ssize_t got = read(file, at, std::min(size, kBytesPerCall));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    size -= size_t(got);
  }
  return true;
}

inline bool WriteWhole(int file, const void* bytes, size_t size) {
  for (const char* at = static_cast<const char*>(bytes); size > 0;) {
    const ssize_t put = write(file, at, std::min(size, kBytesPerCall));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return false;
    at += put;
    size -= size_t(put);
  }
  return true;
}

}  // namespace halfshade
