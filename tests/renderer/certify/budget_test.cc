#include "renderer/budget.h"

#include <gtest/gtest.h>

namespace halfshade {
namespace {

std::string Breach(std::optional<double> predicted, std::optional<double> measured = {}, double ci95 = 0) {
  ErrorReport error;
  error.predicted = predicted;
  error.measured = measured;
  if (measured) error.ci95 = ci95;
  return FindBreach(error, {.max_error = 0.01});
}

TEST(BudgetTest, WithoutABoundNothingBreaksIt) {
  ErrorReport error;
  error.predicted = error.measured = 0.9;
  EXPECT_EQ(FindBreach(error, {}), "");
}

TEST(BudgetTest, ThePredictionCountsWhereNothingWasMeasured) {
  EXPECT_EQ(Breach(0.01), "");
  EXPECT_EQ(Breach(0.0101), "0.01; the error is 0.0101 as predicted");
  EXPECT_EQ(Breach({}), "") << "nothing is known";
}

TEST(BudgetTest, AMeasurementCountsBeforeThePrediction) {
  EXPECT_EQ(Breach(0.05, 0.008, 0.002), "") << "surely met";
  EXPECT_EQ(Breach(0.001, 0.013, 0.002), "0.01; the error is 0.013 +- 0.002 as measured") << "surely broken";
  EXPECT_EQ(Breach({}, 0.013, 0.002), "0.01; the error is 0.013 +- 0.002 as measured");
}

TEST(BudgetTest, WhereTheIntervalHoldsTheBoundThePredictionDecides) {
  EXPECT_EQ(Breach(0.009, 0.012, 0.02), "");
  EXPECT_EQ(Breach(0.02, 0.008, 0.02), "0.01; the error is 0.02 as predicted");
  EXPECT_EQ(Breach({}, 0.008, 0.02), "0.01; the error is 0.008 +- 0.02 as measured") << "nothing says that it was met";
}

}  // namespace
}  // namespace halfshade
