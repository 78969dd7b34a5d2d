// Tone curves of finished frames against the published formulas in double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/renderer/shade/render_image.h"

namespace halfshade {
namespace {

// S. Hill, "ACES fitted", BakingLab (2016): rows.
glm::dvec3 Aces(const glm::dvec3& c) {
  const glm::dvec3 x(0.59719 * c.r + 0.35458 * c.g + 0.04823 * c.b, 0.07600 * c.r + 0.90834 * c.g + 0.01566 * c.b,
                     0.02840 * c.r + 0.13383 * c.g + 0.83777 * c.b);
  const glm::dvec3 y = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
  const glm::dvec3 out(1.60475 * y.r - 0.53108 * y.g - 0.07367 * y.b, -0.10208 * y.r + 1.10813 * y.g - 0.00605 * y.b,
                       -0.00327 * y.r - 0.07276 * y.g + 1.07602 * y.b);
  return glm::clamp(out, 0.0, 1.0);
}

// Khronos, "PBR Neutral Tone Mapping" specification (2024): F90 = .04, Ks = .8 - F90, Kd = .15.
glm::dvec3 Neutral(const glm::dvec3& in) {
  const double x = std::min({in.r, in.g, in.b});
  const double f = x <= 2 * 0.04 ? x - x * x / (4 * 0.04) : 0.04;
  const glm::dvec3 c = in - f;
  const double p = std::max({c.r, c.g, c.b});
  if (p <= 0.76) return c;
  const double pn = 1 - (1 - 0.76) * (1 - 0.76) / (p + 1 - 2 * 0.76);
  const double g = 1 / (0.15 * (p - pn) + 1);
  return c * (pn / p) * g + glm::dvec3(pn) * (1 - g);
}

// A white plate lit by nothing but `color` from everywhere, 2^ev times as bright.
glm::dvec3 ToneMapped(ToneMap curve, const glm::vec3& color, double exposure_ev = 0) {
  GlbMesh plate = MakePlate({0, 0, 0}, 4, 4);
  plate.base_color = {1, 1, 1, 1};
  RenderRequest request;
  request.camera = LookDown(10, 1);
  request.width = request.height = 1;
  request.shading.ambient = color;
  request.shading.exposure_ev = exposure_ev;
  request.shading.tone_map = curve;
  const Image frame = RenderImage(MakeFlatScene({plate}), request, OutputKind::kFrame);
  if (frame.size() == 0) return glm::dvec3(NAN);
  return {frame.at(0, 0, 0), frame.at(0, 0, 1), frame.at(0, 0, 2)};
}

const std::vector<glm::vec3> kColors = {{0, 0, 0},
                                        {0.001f, 0.001f, 0.001f},
                                        {0.05f, 0.1f, 0.07f},
                                        {0.18f, 0.18f, 0.18f},
                                        {0.8f, 0.8f, 0.8f},
                                        {1, 1, 1},
                                        {0.9f, 0.1f, 0.02f},
                                        {4, 4, 4},
                                        {30, 0.5f, 0},
                                        {0, 0, 200},
                                        {1e4f, 1e3f, 1},
                                        {0.08f, 0.5f, 0.9f},
                                        {0.079f, 0.7f, 0.1f},
                                        {5, 4.9f, 4.8f}};

struct Curve {
  ToneMap tone_map;
  glm::dvec3 (*published)(const glm::dvec3&);
};
const Curve kCurves[] = {{ToneMap::kAces, Aces}, {ToneMap::kNeutral, Neutral}};

TEST(ToneMapTest, IsThePublishedCurve) {
  for (const Curve& curve : kCurves) {
    for (const glm::vec3& color : kColors) {
      const glm::dvec3 is = ToneMapped(curve.tone_map, color), should = curve.published(glm::dvec3(color));
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(is[c], should[c], 2e-6) << color.r << "," << color.g << "," << color.b;
    }
  }
}

// Figures by hand. ACES: grey x gives (x (x + .0245786) - .000090537) / (x (.983729 x + .432951) + .238081), since the
// matrices keep grey (their rows sum to 1 but for 1e-5): at 1 1.0244881 / 1.654761 = .6191. Neutral: .8 - .04 = .76;
// at 1 p = .96, 1 - .0576 / (.96 + .24 - .76) = .8691.
TEST(ToneMapTest, KnownValues) {
  EXPECT_NEAR(ToneMapped(ToneMap::kAces, glm::vec3(1)).g, 0.6191, 1e-4);
  EXPECT_NEAR(ToneMapped(ToneMap::kNeutral, glm::vec3(0.8f)).g, 0.76, 1e-6);
  EXPECT_NEAR(ToneMapped(ToneMap::kNeutral, glm::vec3(1)).g, 0.8691, 1e-4);
}

TEST(ToneMapTest, NoneLeavesColoursAsTheyAre) {
  for (const glm::vec3& color : kColors) EXPECT_EQ(ToneMapped(ToneMap::kNone, color), glm::dvec3(color));
}

TEST(ToneMapTest, ExposureComesFirst) {
  for (const Curve& curve : kCurves) {
    EXPECT_EQ(ToneMapped(curve.tone_map, {0.5f, 0.25f, 2}, -1), ToneMapped(curve.tone_map, {0.25f, 0.125f, 1}));
  }
}

TEST(ToneMapTest, GreysGrowAndEverythingStaysWithinTheDisplay) {
  for (const Curve& curve : kCurves) {
    double last = 0;
    for (double ev = -12; ev <= 20; ev += 0.5) {
      const double grey = ToneMapped(curve.tone_map, glm::vec3(1), ev).g;
      EXPECT_GE(grey, last) << ev;
      EXPECT_LE(grey, 1);
      last = grey;
    }
    EXPECT_NEAR(last, 1, 1e-5);
  }
}

// The brightest that a request may ask for, saturated or not: no overflow on the way.
TEST(ToneMapTest, TheBrightestColoursAreWhite) {
  for (const Curve& curve : kCurves) {
    for (const glm::vec3& color : {glm::vec3(1e28f), glm::vec3(1e28f, 1, 0), glm::vec3(65504, 0, 0)}) {
      const glm::dvec3 white = ToneMapped(curve.tone_map, color, color.r > 1e5 ? 32 : 0);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(white[c], 1, 2e-3);
        EXPECT_LE(white[c], 1);
      }
    }
  }
}

}  // namespace
}  // namespace halfshade
