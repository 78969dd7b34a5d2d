#include "client/bench/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halfshade::bench {
namespace {

TEST(MedianTest, IsTheMiddleOneOrTheMeanOfTheTwoInTheMiddle) {
  EXPECT_EQ(Median({3}), 3);
  EXPECT_EQ(Median({9, 1, 5}), 5);
  EXPECT_EQ(Median({1, 9, 4, 2}), 3);
}

TEST(PowerLawExponentTest, FindsThePowerWhateverTheFactor) {
  EXPECT_NEAR(PowerLawExponent({1, 10, 100, 1000}, {7, 70, 700, 7000}), 1, 1e-12);
  EXPECT_NEAR(PowerLawExponent({2, 8}, {3, 3}), 0, 1e-12);
  EXPECT_NEAR(PowerLawExponent({1, 4, 16}, {5, 10, 20}), 0.5, 1e-12);
}

TEST(ParetoFrontTest, HoldsWhatNothingBeats) {
  // The third is dearer and no more exact than the second; the fourth is equal to the first.
  EXPECT_EQ(ParetoFront({1, 2, 3, 1, 9}, {0.5, 0.1, 0.1, 0.5, 0.01}),
            (std::vector<bool>{true, true, false, true, true}));
  EXPECT_TRUE(ParetoFront({}, {}).empty());
}

}  // namespace
}  // namespace halfshade::bench
