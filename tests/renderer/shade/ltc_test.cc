// The table of the specular: fitted again, integrated, and never more than it gets.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "renderer/shade/ltc/fit.h"
#include "renderer/shade/ltc/ggx.h"
#include "renderer/shade/ltc/ltc_table.h"
#include "tests/renderer/shade/specular_truth.h"

namespace halfshade {
namespace {

const LtcEntry& At(int row, int column) { return LtcTable()[size_t(kLtcSize * row + column)]; }

// A view at `cosine` over a surface that looks up at the light from `distance` below its centre.
SurfacePoint Below(double distance, double cosine, double roughness, double f0 = 1) {
  SurfacePoint point;
  point.position = {0, 0, distance};
  point.normal = {0, 0, -1};
  point.view = {std::sqrt(1 - cosine * cosine), 0, -cosine};
  point.roughness = roughness;
  point.f0 = f0;
  return point;
}

TEST(GgxTest, SamplesHaveTheDensityThatIsSaid) {
  // The density times the solid angle of a grid of directions is 1 over the sphere; above the surface alone, less.
  for (const double alpha : {0.1, 0.5, 1.0}) {
    for (const double cosine : {1.0, 0.5, 0.1}) {
      const glm::dvec3 view(std::sqrt(1 - cosine * cosine), 0, cosine);
      constexpr int kSteps = 1000;
      double volume = 0, albedo = 0;
      for (int i = 0; i < kSteps; ++i) {
        for (int j = 0; j < kSteps; ++j) {
          const double z = 1 - (i + 0.5) / kSteps;
          const double around = 2 * M_PI * (j + 0.5) / kSteps;
          const double r = std::sqrt(1 - z * z);
          const glm::dvec3 light(r * std::cos(around), r * std::sin(around), z);
          volume += GgxDensity(view, light, alpha) * 2 * M_PI / (kSteps * kSteps);
          albedo += GgxTimesCosine(view, light, alpha) * 2 * M_PI / (kSteps * kSteps);
        }
      }
      double share = 0, mean = 0;
      for (int i = 0; i < 256; ++i) {
        for (int j = 0; j < 256; ++j) {
          const GgxSample sample = SampleGgx(view, alpha, {(i + 0.5) / 256, (j + 0.5) / 256});
          share += (sample.weight > 0) / 65536.0;
          mean += sample.weight / 65536;
          EXPECT_LE(sample.weight, 1 + 1e-12);
        }
      }
      // A grid over the sphere steps over a lobe .1 wide in a hundred cells, at the horizon in fewer.
      EXPECT_NEAR(volume, share, 2e-3) << alpha << " " << cosine;
      EXPECT_NEAR(albedo, mean, 2e-3) << alpha << " " << cosine;
    }
  }
}

TEST(LtcTableTest, EntriesAreWhatTheFitGives) {
  for (const int row : {0, 20, 63}) {
    // Each column starts from the one before, as in fit_ltc; the first from afar.
    LtcLobe start = PlainLobe(LtcRoughness(row));
    for (int column = 0; column < kLtcSize; ++column) {
      const LtcFit fit = FitLtc(LtcRoughness(row), LtcCosine(column), start);
      start = fit.lobe;
      const LtcEntry& entry = At(row, column);
      const std::string where = std::to_string(row) + " " + std::to_string(column);
      // The table has six digits. The minimum is flat: another start ends up to .3 % from it (row 20, column 54).
      EXPECT_NEAR(entry.albedo, fit.entry.albedo, 1e-5 * entry.albedo) << where;
      EXPECT_NEAR(entry.grazing, fit.entry.grazing, 1e-5 * entry.albedo) << where;
      const double scale = std::max({std::abs(entry.m11), std::abs(entry.m13), std::abs(entry.m31)});
      EXPECT_NEAR(entry.m11, fit.entry.m11, 1e-2 * scale) << where;
      EXPECT_NEAR(entry.m13, fit.entry.m13, 1e-2 * scale) << where;
      EXPECT_NEAR(entry.m31, fit.entry.m31, 1e-2 * scale) << where;
      EXPECT_NEAR(entry.m33, fit.entry.m33, 1e-2 * std::abs(entry.m33)) << where;
    }
  }
}

TEST(LtcTableTest, AFurnaceGivesNoMoreThanItGets) {
  double most = 0, least_share = 1;
  for (int i = 0; i <= 200; ++i) {
    for (int j = 0; j <= 200; ++j) {
      const LtcEntry entry = InterpolateLtc(i / 200.0, j / 200.0);
      ASSERT_TRUE(std::isfinite(entry.m11 * entry.m13 * entry.m31 * entry.m33));
      EXPECT_GT(entry.m11 * entry.m33 - entry.m13 * entry.m31, 0) << i << " " << j;
      EXPECT_GE(entry.grazing, 0);
      EXPECT_LE(entry.grazing, entry.albedo);
      for (const double f0 : {0.0, 0.04, 0.5, 1.0}) {
        most = std::max(most, SpecularAlbedo(entry, f0) * MultipleScattering(entry, f0));
      }
      EXPECT_NEAR(SpecularAlbedo(entry, 1) * MultipleScattering(entry, 1), 1, 1e-12) << "a white metal reflects all";
      least_share = std::min(least_share, LtcShareAbove(entry));
    }
  }
  std::printf("largest albedo %.6f, smallest share above the surface %.3f\n", most, least_share);
  EXPECT_LE(most, 1 + 1e-3);
  EXPECT_GT(most, 0.99) << "a mirror reflects everything";
  EXPECT_GT(least_share, 0.1) << "nothing is divided by what is nearly nothing";
}

TEST(SpecularTest, ALightFromEverywhereReflectsTheAlbedo) {
  for (const double roughness : {0.0, 0.1, 0.3, 0.7, 1.0}) {
    for (const double cosine : {1.0, 0.7, 0.3, 0.05, 0.002}) {
      const SurfacePoint point = Below(1, cosine, roughness);
      const double reflected = SpecularByTable({1e7, 1e7}, point);
      const double albedo = InterpolateLtc(roughness, cosine).albedo;
      // What an edge ten million times as far as the surface leaves at the horizon, through the narrowest lobe.
      EXPECT_NEAR(reflected, albedo, 1e-3) << roughness << " " << cosine;
      EXPECT_LE(reflected, 1 + 1e-3);
    }
  }
}

TEST(SpecularTest, AlbedosAreThoseOfGgx) {
  for (const double roughness : {0.02, 0.11, 0.35, 0.77, 1.0}) {
    for (const double cosine : {0.97, 0.55, 0.21, 0.06}) {
      for (const double f0 : {0.04, 1.0}) {
        const double truth = SpecularByIntegration({1e9, 1e9}, Below(1, cosine, roughness, f0), 192);
        EXPECT_NEAR(SpecularAlbedo(InterpolateLtc(roughness, cosine), f0), truth, 3e-3) << roughness << " " << cosine;
      }
    }
  }
}

// How far a transformed cosine is from GGX: the model's error, not ours. Of the light's radiance.
TEST(SpecularTest, RandomRectanglesReflectWhatGgxReflects) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto direction = [&] {
    std::normal_distribution<double> normal;
    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
  };
  double sum = 0, sum_truth = 0, worst = 0;
  int count = 0;
  while (count < 150) {
    SurfacePoint point;
    point.position = {4 * unit(random) - 2, 4 * unit(random) - 2, 0.2 + 2 * unit(random)};
    point.normal = direction();
    point.view = direction();
    point.roughness = 0.05 + 0.95 * unit(random);
    point.f0 = count % 2 == 0 ? 1 : 0.04;
    if (glm::dot(point.normal, point.view) < 0.05) continue;
    const glm::dvec2 half_edges(0.05 + unit(random), 0.05 + unit(random));
    const double truth = SpecularByIntegration(half_edges, point, 256);
    if (truth < 1e-3) continue;
    const double difference = std::abs(SpecularByTable(half_edges, point) - truth);
    sum += difference;
    sum_truth += truth;
    worst = std::max(worst, difference);
    ++count;
  }
  std::printf("specular of 150 rectangles: mean %.4f, mean difference %.4f, largest %.4f\n", sum_truth / count,
              sum / count, worst);
  // Measured: .0035 and .074; the paper's pictures differ as much at grazing views.
  EXPECT_LE(sum / count, 0.005);
  EXPECT_LE(worst, 0.1);
}

}  // namespace
}  // namespace halfshade
