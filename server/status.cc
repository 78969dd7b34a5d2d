#include "server/status.h"

#include <absl/strings/cord.h>

namespace halfshade {

grpc::Status ToGrpcStatus(const absl::Status& status, const std::string& request_id) {
  if (status.ok()) return grpc::Status::OK;
  std::string message(status.message());
  if (absl::IsInternal(status)) message += " [request " + request_id + "]";
  return grpc::Status(static_cast<grpc::StatusCode>(status.code()), message);
}

grpc::Status EndOfCall(const absl::Status& status, const std::string& request_id,
                       grpc::CallbackServerContext* context) {
  if (const std::string pushback = PushbackMs(status); !pushback.empty()) {
    context->AddTrailingMetadata(kPushbackKey, pushback);
  }
  return ToGrpcStatus(status, request_id);
}

absl::Status ComeBackLater(const std::string& message, std::chrono::milliseconds pause) {
  absl::Status status = absl::ResourceExhaustedError(message);
  status.SetPayload(kPushbackKey, absl::Cord(std::to_string(pause.count())));
  return status;
}

std::string PushbackMs(const absl::Status& status) {
  const auto payload = status.GetPayload(kPushbackKey);
  return payload.has_value() ? std::string(*payload) : std::string();
}

}  // namespace halfshade
