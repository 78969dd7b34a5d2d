#include "renderer/math/form_factor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace halfshade {
namespace {

double SummedLine(const glm::dvec2& half_edge, const glm::dvec3& position, const glm::dvec3& normal, int points) {
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const double t = (2 * i + 1.0) / points - 1;
    sum += PointIrradiance(position - glm::dvec3(half_edge * t, 0), normal);
  }
  return sum / points;
}

TEST(LineIrradianceTest, IsTheMeanOfItsPointsAlsoAcrossTheHorizon) {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> unit(-1, 1);
  int cut = 0;
  for (int round = 0; round < 500; ++round) {
    const glm::dvec2 half_edge(unit(random), unit(random));
    const glm::dvec3 position(2 * unit(random), 2 * unit(random), 1.1 + unit(random));
    const glm::dvec3 normal = glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)));
    const double height_a = glm::dot(glm::dvec3(half_edge, 0) - position, normal);
    const double height_b = glm::dot(glm::dvec3(-half_edge, 0) - position, normal);
    cut += height_a * height_b < 0;
    const double summed = SummedLine(half_edge, position, normal, 4000);
    // Midpoints: the sum errs by the second derivative, largest close to the line.
    EXPECT_NEAR(LineIrradiance(half_edge, position, normal), summed, 1e-4 * summed + 1e-6) << round;
  }
  EXPECT_GT(cut, 50);
}

TEST(LineIrradianceTest, ShrinksToThePointWithoutCancelling) {
  const glm::dvec3 position(0.3, -0.2, 1.5);
  const glm::dvec3 normal = glm::normalize(glm::dvec3(0.2, 0.5, -1));
  const double point = PointIrradiance(position, normal);
  EXPECT_EQ(LineIrradiance({0, 0}, position, normal), point);
  // Down to where the square of a length leaves double's range.
  for (double reach = 1e-5; reach > 1e-150; reach *= 1e-5) {
    EXPECT_NEAR(LineIrradiance({reach, -reach}, position, normal) / point, 1, 2 * reach + 1e-14) << reach;
  }
}

TEST(LineIrradianceTest, IsTheLimitOfThinRectangles) {
  const glm::dvec3 position(0.4, 0.1, 0.8);
  const glm::dvec3 normal = glm::normalize(glm::dvec3(-1, 0.2, -0.3));
  const double line = LineIrradiance({1, 0}, position, normal);
  EXPECT_NEAR(RectangleIrradiance({1, 1e-4}, position, normal) / (4 * 1e-4) / line, 1, 1e-6);
}

TEST(LineIrradianceTest, IsNothingBehindTheLightOrBelowTheHorizon) {
  EXPECT_EQ(LineIrradiance({1, 0}, {0, 0, -1}, {0, 0, 1}), 0);
  EXPECT_EQ(LineIrradiance({1, 0}, {0, 0, 0}, {0, 0, -1}), 0);
  EXPECT_EQ(LineIrradiance({1, 0}, {0, 0, 1}, {0, 0, 1}), 0);
  EXPECT_EQ(LineIrradiance({1, 0}, {0, 0, 1}, {0, 1, 0}), 0) << "edge-on";
}

TEST(RectangleIrradianceTest, ShrinksToThePointWithoutCancelling) {
  const glm::dvec3 position(0.3, -0.2, 1.5);
  const glm::dvec3 normal = glm::normalize(glm::dvec3(0.2, 0.5, -1));
  const double point = PointIrradiance(position, normal);
  for (double half = 1e-2; half > 1e-9; half *= 0.1) {
    EXPECT_NEAR(RectangleIrradiance({half, half}, position, normal) / (4 * half * half) / point, 1,
                4 * half * half + 1e-15 / half)
        << half;
  }
}

}  // namespace
}  // namespace halfshade
