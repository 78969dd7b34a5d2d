#include "renderer/shadow/ssm/choose.h"

#include <gtest/gtest.h>

namespace halfshade {
namespace {

// Occluders a metre wide, a metre before the light.
SsmChoice ChooseFor(double width, double height, const SsmOptions& options = {}) {
  AreaLight light;
  light.width_m = width;
  light.height_m = height;
  OccluderHull hull(width / 2, height / 2, 1);
  hull.AddPoint({-0.5, -0.5, 1});
  hull.AddPoint({0.5, 0.5, 1});
  return ChooseSsm(options, light, hull);
}

TEST(ChooseSsmTest, WiderLightsTakeMoreSubLightsAndSmallerMaps) {
  int sub_lights = 0, map_size = 1 << 20;
  for (const double width : {0.0, 0.01, 0.05, 0.1, 0.2, 0.5, 3.0}) {
    const SsmChoice choice = ChooseFor(width, width);
    EXPECT_GE(choice.sub_lights, sub_lights);
    EXPECT_LE(choice.map_size, map_size);
    sub_lights = choice.sub_lights;
    map_size = choice.map_size;
  }
  EXPECT_EQ(ChooseFor(0, 0).sub_lights, 1);
  EXPECT_EQ(ChooseFor(0, 0).map_size, 512);
  EXPECT_EQ(sub_lights, 4) << "16 maps at most";
  EXPECT_EQ(map_size, 256);
}

TEST(ChooseSsmTest, ALineCountsAsItsLength) { EXPECT_EQ(ChooseFor(0, 0.5).sub_lights, ChooseFor(0.5, 0.5).sub_lights); }

TEST(ChooseSsmTest, AWallThroughTheLightsPlaneTakesTheFinestMaps) {
  AreaLight light;
  light.width_m = light.height_m = 0.5;
  OccluderHull hull(0.25, 0.25, 1e-4);
  hull.AddPoint({-2, -2, 1e-4});
  hull.AddPoint({2, 2, 3});
  ASSERT_TRUE(hull.NeedsSideWindows());
  EXPECT_EQ(ChooseSsm({}, light, hull).map_size, 512);
  EXPECT_EQ(ChooseSsm({}, light, hull).sub_lights, 4);
}

TEST(ChooseSsmTest, WhatIsAskedForStays) {
  const SsmChoice choice = ChooseFor(0.5, 0.5, {.occluder_map_size = 77, .sub_lights = 7});
  EXPECT_EQ(choice.map_size, 77);
  EXPECT_EQ(choice.sub_lights, 7);
}

TEST(ChooseSsmTest, WithoutOccludersItStillChooses) {
  AreaLight light;
  light.width_m = light.height_m = 1;
  const SsmChoice choice = ChooseSsm({}, light, OccluderHull(0.5, 0.5, 1));
  EXPECT_GE(choice.sub_lights, 1);
  EXPECT_GE(choice.map_size, 256);
}

}  // namespace
}  // namespace halfshade
