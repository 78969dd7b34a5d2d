#include "server/status.h"

#include <gtest/gtest.h>

#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using Code = absl::StatusCode;

TEST(ToGrpcStatusTest, OkIsOkAndSaysNothing) {
  const grpc::Status status = ToGrpcStatus(absl::OkStatus(), "r7");
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(status.error_message(), "");
}

TEST(ToGrpcStatusTest, EveryCodeKeepsItsNumberAndOnlyInternalNamesTheRequest) {
  for (int code = int(Code::kCancelled); code <= int(Code::kUnauthenticated); ++code) {
    const grpc::Status status = ToGrpcStatus(absl::Status(Code(code), "width: 9"), "r7");
    EXPECT_EQ(int(status.error_code()), code);
    EXPECT_EQ(status.error_message(), Code(code) == Code::kInternal ? "width: 9 [request r7]" : "width: 9");
  }
}

TEST(PushbackMsTest, IsThePauseOfComeBackLaterInDecimal) {
  const absl::Status status = ComeBackLater("the queue is full", std::chrono::milliseconds(1250));
  EXPECT_THAT(status, StatusIs(Code::kResourceExhausted, testing::StrEq("the queue is full")));
  EXPECT_EQ(PushbackMs(status), "1250");
}

TEST(PushbackMsTest, IsEmptyForAnyOtherStatusSoThatClientsDoNotRetryForEver) {
  EXPECT_EQ(PushbackMs(absl::OkStatus()), "");
  EXPECT_EQ(PushbackMs(absl::ResourceExhaustedError("a scene larger than the cache")), "");
  EXPECT_EQ(PushbackMs(absl::InvalidArgumentError("lights: 65")), "");
}

TEST(PushbackMsTest, DoesNotLeakIntoTheMessage) {
  const grpc::Status status = ToGrpcStatus(ComeBackLater("full", std::chrono::milliseconds(5)), "r1");
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(status.error_message(), "full");
}

}  // namespace
}  // namespace halfshade
