#include "client/exit_code.h"

#include <absl/strings/cord.h>
#include <absl/strings/match.h>

namespace halfshade {
namespace {

constexpr char kPayload[] = "halfshade.exit_code";

}  // namespace

absl::Status WithExitCode(absl::Status status, ExitCode code) {
  status.SetPayload(kPayload, absl::Cord(std::to_string(code)));
  return status;
}

absl::Status UsageError(const std::string& message) {
  return WithExitCode(absl::InvalidArgumentError(message), kExitUsage);
}

absl::Status CannotWriteError(const std::string& message) {
  return WithExitCode(absl::DataLossError(message), kExitCannotWrite);
}

ExitCode ExitCodeOf(const absl::Status& status) {
  if (auto payload = status.GetPayload(kPayload)) return static_cast<ExitCode>(std::stoi(std::string(*payload)));
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return kExitOk;
    case absl::StatusCode::kFailedPrecondition:
      return absl::StartsWith(status.message(), "budget") ? kExitCannotMeetBudget : kExitBadInput;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kOutOfRange:
      return kExitBadInput;
    case absl::StatusCode::kNotFound:
      return kExitNoInput;
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kUnimplemented:
      return kExitUnavailable;
    case absl::StatusCode::kResourceExhausted:
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kAborted:
      return kExitTryAgain;
    case absl::StatusCode::kUnauthenticated:
    case absl::StatusCode::kPermissionDenied:
      return kExitNotAllowed;
    default:
      return kExitInternal;
  }
}

}  // namespace halfshade
