// When a call is made again, and after how long.
#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <optional>
#include <string>

namespace halfshade {

// The pause before the next attempt; nothing where there is none. `attempt` counts from 0.
//   UNAVAILABLE: a restart or a cut connection; `max_attempts` in all, doubling from 0.2 s.
//   RESOURCE_EXHAUSTED: only with the server's push-back (without it nothing says that waiting helps).
//   `pushback` is the metadata grpc-retry-pushback-ms: it sets the pause; a negative or unreadable one forbids a retry.
std::optional<std::chrono::milliseconds> RetryPause(grpc::StatusCode code, const std::optional<std::string>& pushback,
                                                    int attempt, int max_attempts);

}  // namespace halfshade
