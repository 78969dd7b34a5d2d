#include "renderer/gl/pacer.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/support/status_matchers.h"

namespace halfshade::gl {
namespace {

TEST(PacerTest, NoSubmissionIsPredictedOverTheBound) {
  int finishes = 0;
  Pacer pacer([&] { ++finishes; }, [] { return absl::OkStatus(); });
  for (int i = 0; i < 100; ++i) ASSERT_OK(pacer.Charge(7));
  EXPECT_LE(pacer.longest_predicted_ms(), Pacer::kMaxSubmissionMs);
  EXPECT_EQ(finishes, 49) << "two of 7 ms fit 20 ms";
}

TEST(PacerTest, NoMoreDrawsAreUnderWayThanTheContextMayHave) {
  int finishes = 0;
  Pacer pacer([&] { ++finishes; }, [] { return absl::OkStatus(); }, 8);
  for (int i = 0; i < 100; ++i) ASSERT_OK(pacer.Charge(0.001));
  EXPECT_EQ(finishes, 12);
  ASSERT_OK(pacer.Finish());
  EXPECT_EQ(finishes, 13);
  for (int i = 0; i < 8; ++i) ASSERT_OK(pacer.Charge(0.001));
  EXPECT_EQ(finishes, 13) << "counted from the last finish on";
}

TEST(PacerTest, WhatTookLongerThanPredictedIsCutSmaller) {
  Pacer pacer([] { std::this_thread::sleep_for(std::chrono::milliseconds(50)); }, [] { return absl::OkStatus(); });
  EXPECT_EQ(pacer.MostMs(), Pacer::kMaxSubmissionMs);
  ASSERT_OK(pacer.Charge(10));
  ASSERT_OK(pacer.Finish());
  EXPECT_LT(pacer.MostMs(), Pacer::kMaxSubmissionMs / 2.9);
  EXPECT_GE(pacer.MostMs(), Pacer::kMaxSubmissionMs / 8);
}

TEST(PacerTest, TheStopChecksErrorComesBackBeforeMoreIsDrawn) {
  bool stops = false;
  Pacer pacer([] {}, [&] { return stops ? absl::CancelledError("stop") : absl::OkStatus(); });
  ASSERT_OK(pacer.Charge(15));
  stops = true;
  EXPECT_OK(pacer.Charge(4)) << "still within one submission";
  EXPECT_THAT(pacer.Charge(2), StatusIs(absl::StatusCode::kCancelled, "stop"));
}

TEST(PacerTest, FinishWaitsOnlyForWork) {
  int finishes = 0;
  Pacer pacer([&] { ++finishes; }, [] { return absl::OkStatus(); });
  ASSERT_OK(pacer.Finish());
  EXPECT_EQ(finishes, 0);
  ASSERT_OK(pacer.Charge(1));
  ASSERT_OK(pacer.Finish());
  EXPECT_EQ(finishes, 1);
}

}  // namespace
}  // namespace halfshade::gl
