// FRAME at several samples a pixel: coverage of edges, and nothing else.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/renderer/shade/render_image.h"

namespace halfshade {
namespace {

// Coverage of the unit pixel [0,1]^2 by the half plane n.x <= d, in closed form.
double HalfPlaneCoverage(glm::dvec2 n, double d) {
  for (int c = 0; c < 2; ++c) {
    if (n[c] < 0) {  // mirror the pixel
      d -= n[c];
      n[c] = -n[c];
    }
  }
  const double small = std::min(n.x, n.y), large = std::max(n.x, n.y);
  if (d <= 0) return 0;
  if (d >= small + large) return 1;
  if (d > (small + large) / 2) return 1 - HalfPlaneCoverage({small, large}, small + large - d);
  if (d < small) return d * d / (2 * small * large);
  return (d - small / 2) / large;
}

// A white plate under ambient light 1, black elsewhere: red is coverage. The plate's right edge passes through the
// origin, turned by `angle_rad`; one pixel is 1 m.
struct EdgeErrors {
  double max = 0;
  double mean = 0;  // over pixels that the edge crosses
  int crossed = 0;
};

EdgeErrors MeasureEdge(double angle_rad, double offset, int samples, bool is_orthographic) {
  constexpr int kSize = 64;
  GlbMesh plate;
  const glm::dvec2 n(std::cos(angle_rad), std::sin(angle_rad)), along(-n.y, n.x);
  const auto corner = [&](double across, double beside) {
    const glm::dvec2 p = n * (across + offset) + along * beside;
    plate.positions.emplace_back(p.x, 0, p.y);
  };
  corner(-500, -500);
  corner(-500, 500);
  corner(0, 500);
  corner(0, -500);
  plate.indices = {0, 1, 2, 0, 2, 3};
  plate.is_double_sided = true;
  plate.base_color = {1, 1, 1, 1};
  RenderRequest request;
  request.camera = LookDown(100, kSize);
  if (!is_orthographic) {
    request.camera.is_orthographic = false;
    request.camera.tan_half_fovy = kSize / 2.0 / 100;
  }
  request.width = request.height = kSize;
  request.samples = samples;
  request.shading.ambient = glm::vec3(1);
  request.shading.background = glm::vec3(0);
  const Image frame = RenderImage(MakeFlatScene({plate}), request, OutputKind::kFrame);
  EdgeErrors errors;
  if (frame.size() == 0) return errors;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const glm::dvec2 pixel(x - kSize / 2.0, y - kSize / 2.0);
      const double coverage = HalfPlaneCoverage(n, offset - glm::dot(n, pixel));
      EXPECT_EQ(frame.at(x, y, 0), frame.at(x, y, 3)) << "alpha is coverage";
      const double error = std::abs(frame.at(x, y, 0) - coverage);
      errors.max = std::max(errors.max, error);
      if (coverage == 0 || coverage == 1) continue;
      errors.mean += error;
      ++errors.crossed;
    }
  }
  errors.mean /= errors.crossed;
  return errors;
}

// Samples of an upright edge are 1/n apart, so that their share is within 1/(2n) of the coverage.
TEST(FrameSamplesTest, AnUprightEdgesCoverageIsWithinHalfASample) {
  for (const bool is_orthographic : {true, false}) {
    for (const double angle : {0.0, M_PI / 2, M_PI, 3 * M_PI / 2}) {
      for (const int samples : {1, 4, 8}) {
        for (double offset = 0.03; offset < 1; offset += 0.11) {
          const EdgeErrors errors = MeasureEdge(angle, offset, samples, is_orthographic);
          EXPECT_EQ(errors.crossed, 64);
          EXPECT_LE(errors.max, 0.5 / samples + 1e-4) << samples << " samples, offset " << offset;
        }
      }
    }
  }
}

TEST(FrameSamplesTest, ASlantedEdgesCoverageConverges) {
  for (const double angle_deg : {17.0, 45.0, 71.0, 200.0, 340.0}) {
    double last = 1;
    for (const int samples : {1, 4, 8}) {
      const EdgeErrors errors = MeasureEdge(angle_deg * M_PI / 180, 0.37, samples, false);
      std::printf("edge at %3.0f degrees, %d samples: mean error %.4f max %.4f over %d pixels\n", angle_deg, samples,
                  errors.mean, errors.max, errors.crossed);
      EXPECT_GT(errors.crossed, 60);
      EXPECT_LT(errors.mean, last);
      last = errors.mean;
      // Samples at random would be off by sqrt(2/pi) times the mean of sqrt(c (1 - c) / n) over all coverages c, pi/8.
      // The pattern must be better by a quarter, even at 45 degrees, where two of four samples fall together.
      EXPECT_LE(errors.mean, 0.75 * std::sqrt(2 / M_PI / samples) * M_PI / 8);
    }
  }
}

TEST(FrameSamplesTest, WhatFillsItsPixelsIsTheSameAtAnySampleCount) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 40, 40)});
  RenderRequest request;
  request.camera = LookDown(10, 4);
  request.width = request.height = 24;
  request.lights = {LightAbove(1e5, 1e5)};  // even light
  const Image one = RenderImage(scene, request, OutputKind::kFrame);
  ASSERT_GT(one.size(), 0u);
  for (const int samples : {4, 8}) {
    request.samples = samples;
    const Image many = RenderImage(scene, request, OutputKind::kFrame);
    ASSERT_EQ(many.size(), one.size());
    for (size_t i = 0; i < one.size(); ++i) EXPECT_NEAR(many.data()[i], one.data()[i], 1e-6 * one.data()[i]);
  }
}

// Light data is the light's alone: it is drawn once, whatever the samples, and a hard shadow's edge is smoothed as
// well.
TEST(FrameSamplesTest, SamplesShareTheLightsMaps) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request;
  request.camera = LookDown(0.5, 3.2);
  request.width = request.height = 41;  // the edge at .8 m falls inside a pixel
  request.lights = {LightAbove(2, 0)};
  request.method = HardOptions{512};
  const auto maps_and_greys = [&](int samples) {
    request.samples = samples;
    RenderReport report;
    const Image frame = RenderImage(scene, request, OutputKind::kFrame, &report);
    uint64_t maps = 0;
    for (const PassReport& pass : report.passes) {
      if (pass.name.ends_with("light_data")) maps += pass.count;
    }
    const float darkest = frame.at(20, 20, 0);
    // Light falls off from the middle: what is lit between these columns is brighter than there.
    int greys = 0;
    for (int x = 4; x < 36; ++x) {
      greys += frame.at(x, 20, 0) > 1.01f * darkest && frame.at(x, 20, 0) < 0.99f * frame.at(4, 20, 0);
    }
    return std::make_pair(maps, greys);
  };
  EXPECT_EQ(maps_and_greys(1), std::make_pair(uint64_t(1), 0));
  EXPECT_EQ(maps_and_greys(8).first, 1u);
  EXPECT_GT(maps_and_greys(8).second, 0);
}

// A pixel half of which is a hundred times too bright for the display is half bright, not all bright.
TEST(FrameSamplesTest, SamplesAreToneMappedBeforeTheyAreAveraged) {
  GlbMesh plate = MakePlate({-250, 0, 0}, 501, 500);  // its edge is at x = .5: the middle of a pixel
  plate.base_color = {1, 1, 1, 1};
  RenderRequest request;
  request.camera = LookDown(100, 8);
  request.width = request.height = 8;
  request.samples = 4;
  request.shading.ambient = glm::vec3(100);
  request.shading.background = glm::vec3(0);
  request.shading.tone_map = ToneMap::kNeutral;
  const Image frame = RenderImage(MakeFlatScene({plate}), request, OutputKind::kFrame);
  ASSERT_GT(frame.size(), 0u);
  EXPECT_NEAR(frame.at(4, 4, 0), 0.5, 0.01);
  EXPECT_NEAR(frame.at(3, 4, 0), 1, 0.01);
  EXPECT_EQ(frame.at(5, 4, 0), 0);
}

TEST(FrameSamplesTest, TheSameRequestGivesTheSameBytes) {
  const FlatScene scene = MakeFlatScene({MakeSphere({0, 1, 0}, 0.5, 16), MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request;
  request.camera = LookFrom({3, 3, 3}, {0, 0, 0});
  request.width = request.height = 64;
  request.lights = {LightAbove(3, 1), LightAbove(4, 0.2, {1, 0})};
  request.method = MultiMapOptions{8, 128};
  request.samples = 4;
  const Image first = RenderImage(scene, request, OutputKind::kFrame);
  ASSERT_GT(first.size(), 0u);
  EXPECT_TRUE(AreEqual(first, RenderImage(scene, request, OutputKind::kFrame)));
}

}  // namespace
}  // namespace halfshade
