#include "renderer/light/sub_lights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "renderer/math/horizon.h"

namespace halfshade {
namespace {

AreaLight LightOf(double width, double height) {
  AreaLight light;
  light.width_m = width;
  light.height_m = height;
  return light;
}

TEST(SubLightsTest, CellsTileTheLight) {
  const SubLights cells = MakeSubLights(LightOf(3, 1.5), 3);
  ASSERT_EQ(cells.centers.size(), 9u);
  EXPECT_EQ(cells.half_edges, glm::dvec2(0.5, 0.25));
  EXPECT_EQ(cells.centers[0], glm::dvec2(-1, -0.5));
  EXPECT_EQ(cells.centers[4], glm::dvec2(0));
  EXPECT_EQ(cells.centers[8], glm::dvec2(1, 0.5));
}

TEST(SubLightsTest, ALineHasCellsAlongItselfAndAPointIsOne) {
  const SubLights line = MakeSubLights(LightOf(0, 2), 4);
  ASSERT_EQ(line.centers.size(), 4u);
  EXPECT_EQ(line.half_edges, glm::dvec2(0, 0.25));
  EXPECT_EQ(line.centers[3], glm::dvec2(0, 0.75));
  EXPECT_EQ(MakeSubLights(LightOf(0, 0), 4).centers.size(), 1u);
}

TEST(CutCellTest, WhatIsLeftHasTheShareAboveThePlane) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> any(-1, 1);
  for (int i = 0; i < 1000; ++i) {
    const glm::vec2 half(i % 5 == 0 ? 0 : 0.3f, i % 7 == 0 ? 0 : 0.7f);
    const glm::vec2 normal(any(random), i % 11 == 0 ? 0 : any(random));
    const float height = 0.7f * any(random);
    const LitPart part = CutCell(half, normal, height);
    EXPECT_NEAR(part.share, ShareAbovePlane(half, glm::dvec3(normal, 0.5), -height), 1e-5) << i;
    // It stays inside the cell, but for what a rectangle of a triangle's spread sticks out.
    EXPECT_LE(std::abs(part.middle.x), half.x);
    EXPECT_LE(part.half_edges.x, half.x * (1 + 1e-6f));
    EXPECT_LE(part.half_edges.y, half.y * (1 + 1e-6f));
  }
}

TEST(CutCellTest, ACutAlongAnAxisIsExact) {
  const LitPart part = CutCell({2, 1}, {0.5f, 0}, 0.5f);  // above where x > -1
  EXPECT_NEAR(part.share, 0.75f, 1e-6);
  EXPECT_NEAR(part.middle.x, 0.5f, 1e-6);
  EXPECT_NEAR(part.middle.y, 0, 1e-6);
  EXPECT_NEAR(part.half_edges.x, 1.5f, 1e-6);
  EXPECT_NEAR(part.half_edges.y, 1, 1e-6);
}

TEST(CutCellTest, AWholeCellIsItselfAndOneBelowIsNothing) {
  const LitPart whole = CutCell({2, 1}, {0.1f, 0.1f}, 0.5f);
  EXPECT_EQ(whole.share, 1);
  EXPECT_EQ(whole.half_edges, glm::vec2(2, 1));
  EXPECT_EQ(CutCell({2, 1}, {0.1f, 0.1f}, -0.5f).share, 0);
  EXPECT_EQ(CutCell({0, 0}, {0.1f, 0.1f}, 0).share, 0);
  EXPECT_EQ(CutCell({0, 0}, {0.1f, 0.1f}, 1e-9f).share, 1);
}

}  // namespace
}  // namespace halfshade
