#include "client/retry.h"

#include <charconv>

namespace halfshade {

std::optional<std::chrono::milliseconds> RetryPause(grpc::StatusCode code, const std::optional<std::string>& pushback,
                                                    int attempt, int max_attempts) {
  const bool is_unavailable = code == grpc::StatusCode::UNAVAILABLE;
  if (!is_unavailable && code != grpc::StatusCode::RESOURCE_EXHAUSTED) return std::nullopt;
  if (is_unavailable && attempt + 1 >= max_attempts) return std::nullopt;
  if (pushback) {
    int ms = 0;
    const char* end = pushback->data() + pushback->size();
    const auto [stop, error] = std::from_chars(pushback->data(), end, ms);
    if (error != std::errc() || stop != end || ms < 0) return std::nullopt;
    return std::chrono::milliseconds(ms);
  }
  if (!is_unavailable) return std::nullopt;
  return std::chrono::milliseconds(200 << attempt);
}

}  // namespace halfshade
