// absl::Status inside, grpc::Status at the edge.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <string>

namespace halfshade {

// The same code and message; INTERNAL gets the request's id, which the log has too, so that a report can be traced.
grpc::Status ToGrpcStatus(const absl::Status& status, const std::string& request_id);

// The end of a call: ToGrpcStatus, and the pause of ComeBackLater as trailing metadata.
grpc::Status EndOfCall(const absl::Status& status, const std::string& request_id, grpc::CallbackServerContext* context);

// RESOURCE_EXHAUSTED that asks the client to come back after a pause, which EndOfCall sends as trailing metadata
// kPushbackKey (absl carries it as a payload).
absl::Status ComeBackLater(const std::string& message, std::chrono::milliseconds pause);

inline constexpr char kPushbackKey[] = "grpc-retry-pushback-ms";
// The pause of ComeBackLater in decimal, or "" for any other status.
std::string PushbackMs(const absl::Status& status);

}  // namespace halfshade
