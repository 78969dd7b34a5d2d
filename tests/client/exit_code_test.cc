#include "client/exit_code.h"

#include <gtest/gtest.h>

namespace halfshade {
namespace {

TEST(ExitCodeTest, EveryStatusCodeHasTheExitCodeOfTheContract) {
  EXPECT_EQ(ExitCodeOf(absl::OkStatus()), 0);
  EXPECT_EQ(ExitCodeOf(UsageError("x")), 64);
  EXPECT_EQ(ExitCodeOf(absl::InvalidArgumentError("x")), 65);
  EXPECT_EQ(ExitCodeOf(absl::FailedPreconditionError("the result has 8 MiB; use RenderStream")), 65);
  EXPECT_EQ(ExitCodeOf(absl::NotFoundError("x")), 66);
  EXPECT_EQ(ExitCodeOf(absl::UnavailableError("x")), 69);
  EXPECT_EQ(ExitCodeOf(absl::UnimplementedError("x")), 69);
  EXPECT_EQ(ExitCodeOf(absl::InternalError("x")), 70);
  EXPECT_EQ(ExitCodeOf(absl::UnknownError("x")), 70);
  EXPECT_EQ(ExitCodeOf(CannotWriteError("x")), 74);
  EXPECT_EQ(ExitCodeOf(absl::ResourceExhaustedError("x")), 75);
  EXPECT_EQ(ExitCodeOf(absl::DeadlineExceededError("x")), 75);
  EXPECT_EQ(ExitCodeOf(absl::UnauthenticatedError("x")), 77);
  EXPECT_EQ(ExitCodeOf(absl::PermissionDeniedError("x")), 77);
  EXPECT_EQ(ExitCodeOf(absl::FailedPreconditionError("budget.max_error: 1e-9 cannot be met")), 78);
}

}  // namespace
}  // namespace halfshade
