// gmock matchers for absl::Status and absl::StatusOr.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <gmock/gmock.h>

#include <string>

namespace halfshade {

inline const absl::Status& GetStatus(const absl::Status& status) { return status; }
template <typename T>
const absl::Status& GetStatus(const absl::StatusOr<T>& status_or) {
  return status_or.status();
}

MATCHER(IsOk, "is OK") {
  *result_listener << GetStatus(arg).ToString();
  return GetStatus(arg).ok();
}

// StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("width"))
MATCHER_P2(StatusIs, code, message_matcher, "") {
  *result_listener << GetStatus(arg).ToString();
  return GetStatus(arg).code() == code && testing::Matches(message_matcher)(std::string(GetStatus(arg).message()));
}

}  // namespace halfshade

#define ASSERT_OK(expression) ASSERT_THAT(expression, ::halfshade::IsOk())
#define EXPECT_OK(expression) EXPECT_THAT(expression, ::halfshade::IsOk())
