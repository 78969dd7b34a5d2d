#include "renderer/light/window.h"

#include <gtest/gtest.h>

#include <random>

namespace halfshade {
namespace {

TEST(OccluderHullTest, IsEmptyWithoutOccluders) {
  EXPECT_TRUE(OccluderHull(1, 1, 0.1).IsEmpty());
  EXPECT_EQ(OccluderHull(1, 1, 0.1).z_far(), 0.1);
  EXPECT_TRUE(OccluderHull(1, 1, 0.1).FrontWindow({0, 0}).IsEmpty());
}

TEST(OccluderHullTest, IsEmptyWhenEverythingIsBehindTheLight) {
  OccluderHull hull(1, 1, 0.1);
  hull.AddTriangle({0, 0, -1}, {1, 0, -1}, {0, 1, -2});
  EXPECT_TRUE(hull.IsEmpty());
}

TEST(OccluderHullTest, WindowOfTheCentreOfAPointLightIsTheSlopeRange) {
  OccluderHull hull(0, 0, 0.1);
  hull.AddTriangle({-1, 0, 2}, {3, 1, 2}, {0, -1, 4});
  const Window window = hull.FrontWindow({0, 0});
  EXPECT_DOUBLE_EQ(window.u0, -0.5);
  EXPECT_DOUBLE_EQ(window.u1, 1.5);
  EXPECT_DOUBLE_EQ(window.v0, -0.25);
  EXPECT_DOUBLE_EQ(window.v1, 0.5);
  EXPECT_EQ(hull.z_far(), 4);
}

TEST(OccluderHullTest, ContainsEveryOccluderSeenFromEveryPointOfTheLight) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(-1, 1), depth(0.5, 3);
  for (int round = 0; round < 200; ++round) {
    OccluderHull hull(0.4, 0.2, 0.25);
    std::vector<glm::dvec3> points;
    for (int i = 0; i < 6; ++i) points.emplace_back(at(random), at(random), depth(random));
    for (int i = 0; i + 2 < 6; i += 3) hull.AddTriangle(points[i], points[i + 1], points[i + 2]);
    const glm::dvec2 sample(0.4 * at(random), 0.2 * at(random));
    const Window window = hull.FrontWindow(sample);
    for (const glm::dvec3& p : points) {
      EXPECT_GE((p.x - sample.x) / p.z, window.u0 - 1e-12);
      EXPECT_LE((p.x - sample.x) / p.z, window.u1 + 1e-12);
      EXPECT_GE((p.y - sample.y) / p.z, window.v0 - 1e-12);
      EXPECT_LE((p.y - sample.y) / p.z, window.v1 + 1e-12);
    }
  }
}

TEST(OccluderHullTest, GeometryThatCrossesTheLightsPlaneIsClippedNotDropped) {
  OccluderHull hull(0, 0, 0.01);
  hull.AddTriangle({1, 0, -1}, {1, 0.1, -1}, {1, 0, 1});
  EXPECT_FALSE(hull.IsEmpty());
  EXPECT_TRUE(hull.NeedsSideWindows()) << "at z_near it stands at slope 100";
  EXPECT_TRUE(hull.ReachesSide(1));
  EXPECT_FALSE(hull.ReachesSide(2));
  EXPECT_FALSE(hull.ReachesSide(4));
  EXPECT_DOUBLE_EQ(hull.FrontWindow({0, 0}).u1, kSideWindowSlope);
}

TEST(OccluderHullTest, OneWindowServesUpToTheLargestSlope) {
  OccluderHull hull(0, 0, 0.01);
  hull.AddTriangle({7.9, 0, 1}, {7, 0.1, 1}, {7, 0, 1});
  EXPECT_FALSE(hull.NeedsSideWindows());
  EXPECT_DOUBLE_EQ(hull.FrontWindow({0, 0}).u1, 7.9);
  hull.AddTriangle({8.1, 0, 1}, {7, 0.1, 1}, {7, 0, 1});
  EXPECT_TRUE(hull.NeedsSideWindows());
}

TEST(MapFromLightTest, LooksAlongItsSide) {
  const glm::dvec3 directions[5] = {{0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  for (int side = 0; side < 5; ++side) {
    const glm::dvec3 q = MapFromLight(side) * directions[side];
    EXPECT_EQ(q, glm::dvec3(0, 0, 1)) << side;
    if (side > 0) {
      EXPECT_EQ((MapFromLight(side) * glm::dvec3(0, 0, 1)).y, 1) << "the light's normal is up in a side map";
    }
  }
}

}  // namespace
}  // namespace halfshade
