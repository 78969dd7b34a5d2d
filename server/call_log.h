// The end of every call: one line in the log, one count, and the id that both and the client have. Thread-safe.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>

#include <chrono>
#include <memory>
#include <string>

#include "server/metrics.h"

namespace spdlog {
class logger;
}

namespace halfshade {

// Metadata of every end: the request's id, as the log has it.
inline constexpr char kRequestIdKey[] = "x-halfshade-request-id";

class CallLog {
 public:
  struct Call {
    const char* rpc = "";
    std::string id;
    std::string peer;
    std::string traceparent;  // W3C's, as the client sent it; "" where it sent none that is well-formed
    std::chrono::steady_clock::time_point begin;
  };

  explicit CallLog(Metrics* metrics);

  static Call Begin(const char* rpc, const grpc::CallbackServerContext& context);
  // Once a call, before gRPC is told its end: the status and the trailing metadata for that.
  grpc::Status End(const Call& call, const absl::Status& status, grpc::CallbackServerContext* context);

  Metrics* metrics() const { return metrics_; }

 private:
  Metrics* metrics_;
  std::shared_ptr<spdlog::logger> logger_;
};

// "00-<32 hex>-<16 hex>-<2 hex>", lower case, trace and parent not all zeros.
bool IsTraceparent(const std::string& text);

}  // namespace halfshade
