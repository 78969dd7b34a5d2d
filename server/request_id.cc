#include "server/request_id.h"

#include <atomic>

namespace halfshade {

std::string NextRequestId() {
  static std::atomic<unsigned long> next{1};
  return "r" + std::to_string(next++);
}

}  // namespace halfshade
