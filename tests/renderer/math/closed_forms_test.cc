// The closed forms of tests/support against brute force: k points of the light, each seen or not.
#include "tests/support/closed_forms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "renderer/math/sampling.h"

namespace halfshade {
namespace {

// 2^14 scrambled Sobol points: a straight edge splits at most about 2 x 128 of the 128 x 128 cells, each by less than
// one point, and at random: well within 64 of 16384.
constexpr uint32_t kPoints = 1u << 14;
constexpr double kTolerance = 64.0 / kPoints;

// Share of the light's points whose segment to the receiver meets nothing; hides(p) tells for the point at z.
template <typename Hides>
double SampledVisibility(const glm::dvec2& half_edges, double z, const glm::dvec3& receiver, Hides hides) {
  uint32_t seen = 0;
  for (uint32_t i = 0; i < kPoints; ++i) {
    const glm::dvec3 from((OwenSobol2(i, 7) * 2.0 - 1.0) * half_edges, 0);
    seen += z >= receiver.z || !hides(glm::mix(from, receiver, z / receiver.z));
  }
  return double(seen) / kPoints;
}

class ClosedFormTest : public testing::Test {
 protected:
  double Between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  glm::dvec2 Between2(double low, double high) { return {Between(low, high), Between(low, high)}; }

 private:
  std::mt19937 random_{17};
};

TEST_F(ClosedFormTest, APlateHidesTheProductOfTwoIntervals) {
  int partial = 0;
  for (int round = 0; round < 200; ++round) {
    const glm::dvec2 half_edges = Between2(0.05, 0.8);
    const glm::dvec3 center(Between2(-0.3, 0.3), Between(0.1, 1.2));
    const glm::dvec2 half_size = Between2(0.05, 0.6);
    const glm::dvec3 receiver(Between2(-0.8, 0.8), 1);
    const double v = VisibilityBehindPlate(half_edges, center, half_size, receiver);
    partial += v > 0.01 && v < 0.99;
    EXPECT_NEAR(v,
                SampledVisibility(half_edges, center.z, receiver,
                                  [&](const glm::dvec3& p) {
                                    return std::abs(p.x - center.x) <= half_size.x &&
                                           std::abs(p.y - center.y) <= half_size.y;
                                  }),
                kTolerance)
        << round;
  }
  EXPECT_GT(partial, 50);
}

TEST_F(ClosedFormTest, AHalfPlaneHidesTheShareBeyondItsEdge) {
  int partial = 0;
  for (int round = 0; round < 200; ++round) {
    const glm::dvec2 half_edges = Between2(0.05, 0.8);
    const glm::dvec2 normal = Between2(-2, 2);
    const double offset = Between(-0.5, 0.5);
    const double edge_z = Between(0.1, 1.1);
    const glm::dvec3 receiver(Between2(-0.5, 0.5), 1);
    const double v = VisibilityBehindHalfPlane(half_edges, normal, offset, edge_z, receiver);
    partial += v > 0.01 && v < 0.99;
    EXPECT_NEAR(v,
                SampledVisibility(half_edges, edge_z, receiver,
                                  [&](const glm::dvec3& p) { return glm::dot(normal, glm::dvec2(p)) > offset; }),
                kTolerance)
        << round;
  }
  EXPECT_GT(partial, 50);
}

TEST_F(ClosedFormTest, ASphereHidesWhatItsOwnBodyCovers) {
  int partial = 0;
  for (int round = 0; round < 200; ++round) {
    const glm::dvec2 half_edges = Between2(0.1, 1);
    const glm::dvec3 center(Between2(-1, 1), 3);
    const double radius = Between(0.2, 1.5);
    const glm::dvec3 direction = glm::normalize(glm::dvec3(Between2(-1, 1), Between(-0.6, 0.6)));
    const glm::dvec3 receiver = center + direction * radius;
    const double share = SphereHorizonShare(half_edges, center, radius, direction);
    partial += share > 0.01 && share < 0.99;
    // The segment from a point on the sphere enters the sphere exactly if it starts inward.
    uint32_t seen = 0;
    for (uint32_t i = 0; i < kPoints; ++i) {
      const glm::dvec3 from((OwenSobol2(i, 7) * 2.0 - 1.0) * half_edges, 0);
      seen += glm::distance(glm::mix(receiver, from, 1e-6), center) > radius;
    }
    EXPECT_NEAR(share, double(seen) / kPoints, kTolerance) << round;
  }
  EXPECT_GT(partial, 30);
}

TEST_F(ClosedFormTest, ALightIsTheMeanOfItsSubLights) {
  const glm::dvec2 half(0.4, 0.3), plate_size(0.2, 0.25), normal(0.8, -0.6);
  const glm::dvec3 plate(0.1, 0, 0.5), low(-0.1, -0.2, 0.3), high(0.2, 0.1, 0.6);
  for (const int q : {2, 4}) {
    for (double x = -0.9; x < 0.9; x += 0.037) {
      const glm::dvec3 receiver(x, 0.2 - x / 3, 1);
      double behind_plate = 0, behind_half_plane = 0, behind_box = 0;
      const glm::dvec2 part = half / double(q);
      for (int i = 0; i < q * q; ++i) {
        const glm::dvec3 shift(part * (2.0 * glm::dvec2(i % q, i / q) + 1.0 - double(q)), 0);
        const double share = 1.0 / (q * q);
        behind_plate += share * VisibilityBehindPlate(part, plate - shift, plate_size, receiver - shift);
        behind_half_plane += share * VisibilityBehindHalfPlane(part, normal, 0.1 - glm::dot(normal, glm::dvec2(shift)),
                                                               0.5, receiver - shift);
        behind_box += share * VisibilityBehindBox(part, low - shift, high - shift, receiver - shift);
      }
      EXPECT_NEAR(VisibilityBehindPlate(half, plate, plate_size, receiver), behind_plate, 1e-12);
      EXPECT_NEAR(VisibilityBehindHalfPlane(half, normal, 0.1, 0.5, receiver), behind_half_plane, 1e-12);
      EXPECT_NEAR(VisibilityBehindBox(half, low, high, receiver), behind_box, 1e-12);
    }
  }
}

TEST(ClosedFormEdgeTest, PointLightsSeeAllOrNothing) {
  EXPECT_EQ(VisibilityBehindPlate({0, 0}, {0, 0, 0.5}, {0.2, 0.2}, {0.1, 0.1, 1}), 0);
  EXPECT_EQ(VisibilityBehindPlate({0, 0}, {0, 0, 0.5}, {0.2, 0.2}, {0.5, 0.1, 1}), 1);
  EXPECT_EQ(VisibilityBehindHalfPlane({0, 0}, {1, 0}, 0.1, 0.5, {0.3, 0, 1}), 0);
  EXPECT_EQ(VisibilityBehindHalfPlane({0, 0}, {1, 0}, 0.1, 0.5, {0.1, 0, 1}), 1);
}

TEST(ClosedFormEdgeTest, WhatStandsBeyondTheReceiverHidesNothing) {
  EXPECT_EQ(VisibilityBehindPlate({1, 1}, {0, 0, 1}, {5, 5}, {0, 0, 1}), 1);
  EXPECT_EQ(VisibilityBehindHalfPlane({1, 1}, {1, 0}, -9, 2, {0, 0, 1}), 1);
}

TEST_F(ClosedFormTest, ABoxHidesTheHullOfItsCorners) {
  int partial = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const glm::dvec2 half_edges = Between2(0.1, 1);
    const glm::dvec3 low(Between2(-1, 0.5), Between(0.5, 1.5));
    const glm::dvec3 high = low + glm::dvec3(Between2(0.1, 0.8), Between(0.05, 0.4));
    const glm::dvec3 receiver(Between2(-1, 1), Between(2, 4));
    uint32_t seen = 0;
    for (uint32_t i = 0; i < kPoints; ++i) {
      // The segment from the light to the receiver against the box's three slabs.
      const glm::dvec3 from((OwenSobol2(i, 7) * 2.0 - 1.0) * half_edges, 0);
      const glm::dvec3 a = (low - from) / (receiver - from), b = (high - from) / (receiver - from);
      const glm::dvec3 enter = glm::min(a, b), leave = glm::max(a, b);
      seen += std::max({enter.x, enter.y, enter.z}) > std::min({leave.x, leave.y, leave.z});
    }
    const double v = VisibilityBehindBox(half_edges, low, high, receiver);
    EXPECT_NEAR(v, double(seen) / kPoints, kTolerance) << trial;
    partial += v > 0.01 && v < 0.99;
  }
  EXPECT_GT(partial, 50);
}

}  // namespace
}  // namespace halfshade
