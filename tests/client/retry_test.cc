#include "client/retry.h"

#include <gtest/gtest.h>

namespace halfshade {
namespace {

using std::chrono::milliseconds;

TEST(RetryTest, UnavailableIsTriedAgainWithGrowingPausesUpToTheLimit) {
  EXPECT_EQ(RetryPause(grpc::StatusCode::UNAVAILABLE, std::nullopt, 0, 3), milliseconds(200));
  EXPECT_EQ(RetryPause(grpc::StatusCode::UNAVAILABLE, std::nullopt, 1, 3), milliseconds(400));
  EXPECT_EQ(RetryPause(grpc::StatusCode::UNAVAILABLE, std::nullopt, 2, 3), std::nullopt);
}

TEST(RetryTest, PushBackSetsThePauseToTheMillisecond) {
  EXPECT_EQ(RetryPause(grpc::StatusCode::RESOURCE_EXHAUSTED, "1234", 0, 3), milliseconds(1234));
  EXPECT_EQ(RetryPause(grpc::StatusCode::RESOURCE_EXHAUSTED, "0", 50, 3), milliseconds(0));
  EXPECT_EQ(RetryPause(grpc::StatusCode::UNAVAILABLE, "7", 0, 3), milliseconds(7));
}

TEST(RetryTest, NegativeOrUnreadablePushBackForbidsARetry) {
  EXPECT_EQ(RetryPause(grpc::StatusCode::UNAVAILABLE, "-1", 0, 3), std::nullopt);
  EXPECT_EQ(RetryPause(grpc::StatusCode::RESOURCE_EXHAUSTED, "soon", 0, 3), std::nullopt);
  EXPECT_EQ(RetryPause(grpc::StatusCode::RESOURCE_EXHAUSTED, "10x", 0, 3), std::nullopt);
}

TEST(RetryTest, ExhaustionWithoutPushBackIsFinal) {
  EXPECT_EQ(RetryPause(grpc::StatusCode::RESOURCE_EXHAUSTED, std::nullopt, 0, 3), std::nullopt);
}

TEST(RetryTest, NothingElseIsTriedAgain) {
  for (const auto code : {grpc::StatusCode::INVALID_ARGUMENT, grpc::StatusCode::INTERNAL, grpc::StatusCode::NOT_FOUND,
                          grpc::StatusCode::DEADLINE_EXCEEDED, grpc::StatusCode::UNIMPLEMENTED}) {
    EXPECT_EQ(RetryPause(code, "5", 0, 3), std::nullopt) << code;
  }
}

}  // namespace
}  // namespace halfshade
