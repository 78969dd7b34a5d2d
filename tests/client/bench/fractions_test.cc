#include "client/bench/fractions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace halfshade::bench {
namespace {

TEST(FigureAtTest, LiesOnTheLineThroughTheLogarithms) {
  // Four times the cost for half the error; a setting that is beaten does not count.
  const std::vector<double> cost = {10, 160, 40, 100}, error = {0.04, 0.01, 0.02, 0.03};
  EXPECT_DOUBLE_EQ(*FigureAt(cost, error, cost, 0.02), 40);
  EXPECT_NEAR(*FigureAt(cost, error, cost, 0.02 / std::sqrt(2.0)), 80, 1e-9);
  EXPECT_DOUBLE_EQ(*FigureAt(cost, error, cost, 0.5), 10) << "no cheaper than its coarsest";
  EXPECT_FALSE(FigureAt(cost, error, cost, 0.009)) << "it does not get there";
  EXPECT_DOUBLE_EQ(*FigureAt(cost, error, {1, 2, 3, 4}, 0.02), 3) << "another figure of the same settings";
}

Row MakeRow(const char* method, const char* family, double cpu_ms, double error) {
  Row row;
  row.setting.method = method;
  row.setting.label = family;
  row.setting.family = family;
  row.cpu_ms = cpu_ms;
  row.shadow_cpu_ms = cpu_ms - 10;
  row.error.mae_shadowed = error;
  row.error.p999 = 10 * error;
  return row;
}

TEST(FractionsTest, TheCheapestRivalOfAnyFamilyStandsBeside) {
  CaseResult result;
  result.rows = {MakeRow("own", "8", 20, 0.008),    MakeRow("own", "64", 30, 0.004),   MakeRow("ray", "ray", 110, 0.03),
                 MakeRow("ray", "ray", 410, 0.001), MakeRow("pcss", "pcss", 60, 0.01), MakeRow("hard", "hard", 5, 0.5)};
  result.rows.push_back(MakeRow("own", "broken", 1, 0));
  result.rows.back().failure = "INTERNAL";
  const std::vector<Fraction> fractions = FractionsOf(result, "own");
  ASSERT_EQ(fractions.size(), 4u);
  EXPECT_EQ(fractions[0].own, "8");
  EXPECT_EQ(fractions[0].rival, "pcss");
  EXPECT_DOUBLE_EQ(fractions[0].p999, 0.08 / 0.1);
  EXPECT_TRUE(fractions[0].single.empty());
  EXPECT_DOUBLE_EQ(fractions[0].whole, 20.0 / 60);
  EXPECT_DOUBLE_EQ(fractions[0].shadow, 10.0 / 50);
  EXPECT_FALSE(fractions[0].IsMissed());
  EXPECT_TRUE(fractions[1].IsMissed()) << "a third is over a fifth";
  EXPECT_EQ(fractions[2].own, "64");
  EXPECT_EQ(fractions[2].rival, "ray") << "pcss does not get to .005";
  EXPECT_TRUE(fractions[3].own.empty());
  EXPECT_TRUE(fractions[3].IsMissed());
  result.is_dense = true;
  EXPECT_FALSE(FractionsOf(result, "own")[1].IsMissed()) << "half is the aim of dense meshes";
}

TEST(FractionsTest, OurOtherMethodsStandBesideButAreNoRivals) {
  CaseResult result;
  result.rows = {MakeRow("auto", "03", 25, 0.02), MakeRow("auto", "01", 40, 0.004), MakeRow("ray", "ray", 100, 0.009),
                 MakeRow("shaft", "shaft", 20, 0.009), MakeRow("ssm", "ssm", 30, 0.001)};
  result.rows[0].setting.max_error = 0.03;
  result.rows[1].setting.max_error = 0.01;
  const std::vector<Fraction> fractions = FractionsOf(result, "auto");
  EXPECT_EQ(fractions[0].rival, "ray");
  EXPECT_DOUBLE_EQ(fractions[0].whole, 0.25);
  EXPECT_EQ(fractions[0].single, "shaft");
  EXPECT_DOUBLE_EQ(fractions[0].of_single, 1.25);
  EXPECT_EQ(fractions[1].own, "01") << "as exact as .005 asks for, but asked for .01";
  EXPECT_DOUBLE_EQ(fractions[1].of_single, 2);
  EXPECT_TRUE(fractions[2].own.empty());
  EXPECT_EQ(fractions[2].single, "ssm");
}

TEST(FractionsTest, RaysThatABudgetStopsAreOurOwn) {
  CaseResult result;
  result.rows = {MakeRow("auto", "auto", 25, 0.009), MakeRow("ray", "ray", 100, 0.009),
                 MakeRow("ray", "ray adaptive by budget", 20, 0.009)};
  result.rows[2].setting.max_error = 0.01;
  const std::vector<Fraction> fractions = FractionsOf(result, "auto");
  EXPECT_EQ(fractions[1].rival, "ray");
  EXPECT_EQ(fractions[1].single, "ray adaptive by budget");
  EXPECT_DOUBLE_EQ(fractions[1].of_single, 1.25);
}

}  // namespace
}  // namespace halfshade::bench
