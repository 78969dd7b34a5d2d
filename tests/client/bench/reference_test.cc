#include "client/bench/reference.h"

#include <gtest/gtest.h>

namespace halfshade::bench {
namespace {

// A rectangle's variance along an edge is 1/12 of the edge's square: the Gaussian stands for it with the same.
TEST(GaussianLightsTest, HaveTheWeightMeanAndVarianceOfTheRectangle) {
  double weight = 0, mean = 0, variance = 0;
  const std::vector<WeighedPoint> points = GaussianLights(41);
  ASSERT_EQ(points.size(), 41u * 41);
  for (const WeighedPoint& point : points) {
    weight += point.weight;
    mean += point.weight * point.u;
    variance += point.weight * point.u * point.u;
  }
  EXPECT_NEAR(weight, 1, 1e-12);
  EXPECT_NEAR(mean, 0, 1e-12);
  EXPECT_NEAR(variance, 1.0 / 12, 1e-4);
  EXPECT_EQ(points[20 * 41 + 20].u, 0) << "the middle one is the light's centre";
  EXPECT_GT(points[20 * 41 + 20].weight, points[0].weight);
}

}  // namespace
}  // namespace halfshade::bench
