#include "server/request_id.h"

#include <absl/strings/str_format.h>

#include <atomic>
#include <random>

namespace halfshade {

std::string NextRequestId() {
  static const std::string process = absl::StrFormat("%06x", std::random_device()() & 0xffffff);
  static std::atomic<unsigned long> next{1};
  return process + "-" + std::to_string(next++);
}

}  // namespace halfshade
