// What the process says to a shell. The library carries absl::Status; a canonical code tells the exit code in most
// cases, and a payload does where it does not (a wrong command line, a file that cannot be written).
#pragma once

#include <absl/status/status.h>

#include <string>

namespace halfshade {

enum ExitCode : int {
  kExitOk = 0,
  kExitUsage = 64,             // the command line
  kExitBadInput = 65,          // INVALID_ARGUMENT, FAILED_PRECONDITION, a refused scene
  kExitNoInput = 66,           // no such file, unknown scene
  kExitUnavailable = 69,       // UNAVAILABLE, UNIMPLEMENTED
  kExitInternal = 70,          // a bug
  kExitCannotWrite = 74,       // an output file or stdout
  kExitTryAgain = 75,          // RESOURCE_EXHAUSTED, DEADLINE_EXCEEDED
  kExitNotAllowed = 77,        // UNAUTHENTICATED, PERMISSION_DENIED
  kExitCannotMeetBudget = 78,  // FAILED_PRECONDITION whose message starts with "budget"
};

// `status` (an error), exiting with `code` whatever its own code says.
absl::Status WithExitCode(absl::Status status, ExitCode code);
// INVALID_ARGUMENT that exits 64.
absl::Status UsageError(const std::string& message);
// DATA_LOSS that exits 74.
absl::Status CannotWriteError(const std::string& message);

ExitCode ExitCodeOf(const absl::Status& status);

}  // namespace halfshade
