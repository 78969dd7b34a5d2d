// What the door gets from SHAFT beside visibility.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "renderer/image/compare.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

using testing::StartsWith;

const PassReport* ResolveOf(const RenderReport& report) {
  for (const PassReport& pass : report.passes) {
    if (pass.name == "light[0]/resolve") return &pass;
  }
  return nullptr;
}

TEST(ShaftReportTest, ThePredictedErrorIsTheTrueOneWithinAFactorOfTwo) {
  for (const char* name : {"S2", "S3", "S5"}) {
    const MadeScene made = MakeScene(name, {.light_share = 0.2});
    const FlatScene scene = MakeFlatScene(made.meshes);
    RenderRequest request = RequestFor(made);
    request.width = 160;
    request.height = 90;
    request.method = RayOptions{4096};
    const Image truth = RenderVisibility(scene, request);
    request.method = ShaftOptions{16};
    RenderReport report;
    const Image v = RenderVisibility(scene, request, &report);
    const auto error = Compare(truth, v, nullptr);
    ASSERT_OK(error);
    ASSERT_TRUE(report.error.predicted);
    std::printf("%s: error %.5f, predicted %.5f\n", name, *error->mae_shadowed, *report.error.predicted);
    EXPECT_GT(*report.error.predicted, *error->mae_shadowed / 2) << name;
    EXPECT_LT(*report.error.predicted, *error->mae_shadowed * 2) << name;
  }
}

TEST(ShaftReportTest, TilesWithNothingInTheirShaftsAreCountedAsLit) {
  // 4 x 4 tiles of a ground, and a plate whose shadow is within the one that is first in both axes.
  RenderRequest request;
  request.camera = LookDown(0.2, 4);
  request.width = request.height = 64;
  request.lights = {LightAbove(2, 0.1, {-1.5, -1.5})};
  request.method = ShaftOptions{16};
  RenderReport report;
  RenderVisibility(MakeFlatScene({MakePlate({0, 0, 0}, 8, 8), MakePlate({-1.5, 1, -1.5}, 0.1, 0.1)}), request, &report);
  const PassReport* resolve = ResolveOf(report);
  ASSERT_NE(resolve, nullptr);
  EXPECT_THAT(resolve->reason, StartsWith("15 tiles lit"));
  EXPECT_GT(resolve->count, 0u);
  EXPECT_LE(resolve->count, 16u);  // the one polygon, in blocks of one tile
}

}  // namespace
}  // namespace halfshade
