// Soft shadow maps that pictures look their visibility up in, through the renderer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/support/closed_forms.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

constexpr int kPixels = 96;

SsmOptions Scatter(SsmOptions options = {.sub_lights = 1, .measures_coverage = false}) {
  options.occluder_map_size = 64;
  options.accumulation = SsmAccumulation::kScatter;
  options.projects_map = true;
  return options;
}

SsmOptions Map(SsmOptions options = {}) {
  options.projects_map = true;
  return options;
}

class ProjectedMapTest : public testing::Test {
 protected:
  // Of a plate 1 m before a light that is 2 m above the ground; the camera looks down from below the plate,
  // so that all that it sees receives.
  ProjectedMapTest() : scene_(MakeFlatScene({MakePlate({0.1, 1, 0}, 0.8, 0.8)})) {
    request_.camera = LookDown(0.9, 2);
    request_.ground = Ground{2e-4, 2, false};  // at y = 0
    request_.lights = {LightAbove(2, 0.4)};
    request_.width = request_.height = kPixels;
    request_.outputs = {OutputKind::kVisibility};
    request_.light_map_size = 128;
  }
  ~ProjectedMapTest() override { TestRenderer().ForgetScene("test"); }

  Image Draw(const MethodOptions& method) {
    request_.method = method;
    auto result = TestRenderer().Render("test", scene_, request_, [] { return absl::OkStatus(); });
    EXPECT_OK(result);
    if (!result.ok()) return {};
    report_ = result->report;
    return std::move(result->images[0].image);
  }

  // Mean over the pixels that the plate's shadow reaches.
  double ErrorBehindPlate(const Image& v) const {
    double error = 0;
    int shadowed = 0;
    for (int y = 0; y < kPixels; ++y) {
      for (int x = 0; x < kPixels; ++x) {
        const glm::dvec2 at = (glm::dvec2(x, y) + 0.5) * (2.0 / kPixels) - 1.0;
        const double truth = VisibilityBehindPlate({0.2, 0.2}, {0.1, 0, 1}, {0.4, 0.4}, {at, 2});
        if (truth > 1 - 1.0 / 512) continue;
        ++shadowed;
        error += std::abs(v.at(x, y, 0) - truth);
      }
    }
    EXPECT_GT(shadowed, 1000);
    return error / shadowed;
  }

  const PassReport* FindPass(const std::string& name) const {
    for (const PassReport& pass : report_.passes) {
      if (pass.name == name) return &pass;
    }
    return nullptr;
  }

  FlatScene scene_;
  RenderRequest request_;
  RenderReport report_;
};

// The occluder map's window is the plate: patches end where it does. A texel of the soft shadow map bends ramps at
// their ends: by 1/8 of its slope h / (L dw) = .05 there, in some 4 of 60 texels across.
TEST_F(ProjectedMapTest, BothAccumulationsGiveThePlatesTrapezoidInOnePassAndInTwo) {
  for (const SsmOptions& options :
       {Scatter(), Scatter({.passes = 2, .sub_lights = 1, .measures_coverage = false}), Scatter({.sub_lights = 2}),
        Map({.sub_lights = 1}), Map(), Map({.passes = 2, .sub_lights = 2})}) {
    const double error = ErrorBehindPlate(Draw(options));
    std::printf("passes %d, q %d, %s: mae_shadowed %.5f\n", options.passes, options.sub_lights,
                options.accumulation == SsmAccumulation::kScatter ? "SCATTER" : "BINNED", error);
    EXPECT_LE(error, 0.001);
  }
}

TEST_F(ProjectedMapTest, AMapGivesReceiversWhatTheGatherGivesThem) {
  scene_ = MakeFlatScene({MakeSphere({0, 1.1, 0}, 0.4, 24)});
  request_.camera = LookDown(0.5, 3);
  request_.ground->size_m = 4;
  request_.light_map_size = 512;
  const Image pixels = Draw(SsmOptions{.occluder_map_size = 256, .sub_lights = 2});
  const Image map = Draw(Map({.occluder_map_size = 256, .sub_lights = 2}));
  double worst = 0, mean = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const double d = std::abs(double(map.data()[i]) - pixels.data()[i]);
    worst = std::max(worst, d);
    mean += d / double(pixels.size());
  }
  std::printf("MAP of 512 against PIXELS: mean %.2g, largest %.2g\n", mean, worst);
  EXPECT_GT(*std::max_element(pixels.data(), pixels.data() + pixels.size()), 0.99);
  EXPECT_LT(*std::min_element(pixels.data(), pixels.data() + pixels.size()), 0.01);
  EXPECT_LE(mean, 5e-4);
  EXPECT_LE(worst, 1e-2);
}

TEST_F(ProjectedMapTest, AnotherCameraPaysTheProjectionAloneAndAnotherGroundDoesNot) {
  Draw(Scatter());
  ASSERT_NE(FindPass("light[0]/light_data"), nullptr);
  EXPECT_FALSE(FindPass("light[0]/light_data")->is_skipped);
  EXPECT_EQ(FindPass("light[0]/light_data")->count, 1u);
  const auto cache = std::find_if(report_.caches.begin(), report_.caches.end(),
                                  [](const CacheReport& c) { return c.name == "light[0]/light_data"; });
  ASSERT_NE(cache, report_.caches.end());
  EXPECT_EQ(cache->bytes, 128u * 128 * 8) << "the map, and nothing of what it was made from";
  request_.camera = LookDown(0.8, 1.5);
  Draw(Scatter());
  EXPECT_TRUE(FindPass("light[0]/light_data")->is_skipped) << "cached";
  EXPECT_EQ(FindPass("light[0]/resolve")->count, 0u) << "no map is drawn again";
  request_.ground->height_m += 0.1;
  Draw(Scatter());
  EXPECT_FALSE(FindPass("light[0]/light_data")->is_skipped);
  request_.ground->height_m -= 0.1;
  request_.camera.target_ws.x += 0.2;  // under which the ground lies
  Draw(Scatter());
  EXPECT_FALSE(FindPass("light[0]/light_data")->is_skipped);
  Draw(Map());
  EXPECT_FALSE(FindPass("light[0]/light_data")->is_skipped);
}

TEST_F(ProjectedMapTest, TheSoftShadowMapOfTheRequestIsTheOneThatIsProjected) {
  request_.outputs = {OutputKind::kSoftShadowMap};
  request_.light_map_size = 64;
  const Image gathered = Draw(SsmOptions{.sub_lights = 2});
  const Image projected = Draw(Map({.sub_lights = 2}));
  ASSERT_EQ(gathered.size(), projected.size());
  ASSERT_EQ(gathered.width(), 64);
  for (size_t i = 0; i < gathered.size(); ++i) ASSERT_NEAR(projected.data()[i], gathered.data()[i], 1e-4);
}

TEST_F(ProjectedMapTest, TheLargestSumBeforeClampingIsReportedAndThePatches) {
  Draw(Scatter());
  EXPECT_NEAR(report_.max_sum, 1, 1e-3) << "patches of one plate do not overlap";
  ASSERT_NE(FindPass("light[0]/resolve"), nullptr);
  EXPECT_NE(FindPass("light[0]/resolve")->reason.find(" patches; one hides 1/"), std::string::npos);
  // Two plates, one behind the other: where both hide all, sums are 2.
  scene_ = MakeFlatScene({MakePlate({0, 1, 0}, 0.9, 0.9), MakePlate({0.3, 1.4, 0}, 0.2, 0.2)});
  TestRenderer().ForgetScene("test");
  const Image v = Draw(Scatter({.passes = 1, .sub_lights = 1, .measures_coverage = false}));
  EXPECT_GT(report_.max_sum, 1.05);
  EXPECT_EQ(*std::min_element(v.data(), v.data() + v.size()), 0);
}

// A wall through the light's plane: beyond slope 1 each cell's centre decides, in maps of both accumulations.
TEST_F(ProjectedMapTest, WhatStandsBesideTheLightHidesToo) {
  scene_ = MakeFlatScene({MakePlate({0.1, 1, 0}, 0.4, 0.4), MakeBox({1.2, 2, 0}, {0.1, 4, 3})});
  request_.ground->size_m = 4;
  request_.camera = LookDown(0.3, 4);
  const Image truth = Draw(RayOptions{256});
  for (const SsmOptions& options : {Scatter({.sub_lights = 4}), Map({.occluder_map_size = 128, .sub_lights = 4})}) {
    const Image v = Draw(options);
    double error = 0;
    int behind = 0, dark = 0;
    for (int y = 0; y < kPixels; ++y) {
      for (int x = 0; x < kPixels; ++x) {
        error += std::abs(v.at(x, y, 0) - truth.at(x, y, 0)) / (kPixels * kPixels);
        if ((x + 0.5) * 4 / kPixels - 2 < 1.3 || truth.at(x, y, 0) > 0) continue;
        ++behind;
        dark += v.at(x, y, 0) <= 0.01f;
      }
    }
    std::printf("%s: mae %.4f, dark %d of %d behind the wall\n",
                options.accumulation == SsmAccumulation::kScatter ? "SCATTER" : "BINNED", error, dark, behind);
    EXPECT_LE(error, 0.02);
    // All but a texel at the end of the shadow.
    EXPECT_GE(dark, behind * 97 / 100);
    EXPECT_GT(behind, 1000);
  }
}

// As in the paper: what casts receives no shadow where something does not cast.
TEST_F(ProjectedMapTest, OccludersStayLitAndWhatStandsBehindTheGroundGetsItsShadow) {
  request_.camera = LookDown(3, 2);
  for (const SsmOptions& options : {Scatter(), Map()}) {
    const Image v = Draw(options);
    EXPECT_EQ(v.at(kPixels / 2, kPixels / 2, 0), 1) << "on the plate";
    EXPECT_EQ(v.at(1, kPixels / 2, 0), 1) << "ground beyond the shadow";
  }
}

// Where everything casts, the map shows what the light sees first: it is lit, and what is behind it is dark.
TEST_F(ProjectedMapTest, WhereEverythingCastsItReceivesToo) {
  scene_ = MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 0, 0}, 4, 4)});
  request_.ground = std::nullopt;
  request_.camera = LookDown(0.9, 3);
  const Image v = Draw(Map());
  EXPECT_EQ(v.at(kPixels / 2, kPixels / 2, 0), 0);
  EXPECT_EQ(v.at(1, 1, 0), 1);
}

}  // namespace
}  // namespace halfshade
