#include "renderer/certify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "renderer/light/trace_light.h"
#include "renderer/scene/pose.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

constexpr int kWidth = 80;
constexpr int kHeight = 60;

// Shadow in a corner of 20 x 15, light elsewhere; the right half faces away.
Image Picture() {
  Image pairs(kWidth, kHeight, 2);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      float* const pair = pairs.data() + 2 * (y * kWidth + x);
      pair[0] = x < 20 && y < 15 ? 0.25f : 1.0f;
      pair[1] = x < 40 ? 1.0f : 0.0f;
    }
  }
  return pairs;
}

TEST(ChoosePixelsTest, TakesAThirdEachFromShadowItsFringeAndLightAndNoneThatFacesAway) {
  const auto chosen = ChoosePixels(Picture(), 180, 1);
  ASSERT_EQ(chosen.size(), 180u);
  std::set<uint32_t> distinct;
  double weight[3] = {};
  int count[3] = {};
  for (const ChosenPixel& pixel : chosen) {
    distinct.insert(pixel.index);
    const int x = int(pixel.index) % kWidth;
    const int y = int(pixel.index) / kWidth;
    EXPECT_LT(x, 40);
    EXPECT_EQ(pixel.stratum, x < 20 && y < 15 ? 0u : x < 24 && y < 16 ? 1u : 2u);
    weight[pixel.stratum] += pixel.weight;
    ++count[pixel.stratum];
  }
  EXPECT_EQ(distinct.size(), 180u);
  for (const int pixels : count) EXPECT_EQ(pixels, 60);
  EXPECT_EQ(weight[0], 20 * 15);
  EXPECT_EQ(weight[1], 24 * 16 - 20 * 15);
  EXPECT_EQ(weight[2], 40 * 60 - 24 * 16);
}

TEST(ChoosePixelsTest, SpreadsThemOverThePicture) {
  int quarters[4] = {};
  for (const ChosenPixel& pixel : ChoosePixels(Picture(), 600, 3)) {
    if (pixel.stratum == 2) ++quarters[int(pixel.index) / kWidth / 15];
  }
  // 600 of the 2016 pixels of light that no shadow is near stand in each of the lower quarters; the fringe has 84 only.
  for (const int quarter : {2, 3}) EXPECT_NEAR(quarters[quarter], (600 - 84) / 2 * 600.0 / 2016, 6) << quarter;
}

TEST(ChoosePixelsTest, TakesAllWhereThereAreNoMore) {
  const auto chosen = ChoosePixels(Picture(), 100000, 1);
  EXPECT_EQ(chosen.size(), 40u * 60u);
  for (const ChosenPixel& pixel : chosen) EXPECT_EQ(pixel.weight, 1);
  // A third that has fewer leaves the rest to the others.
  int count[3] = {};
  for (const ChosenPixel& pixel : ChoosePixels(Picture(), 1000, 1)) ++count[pixel.stratum];
  EXPECT_EQ(count[0], 300);
  EXPECT_EQ(count[1], 84);
  EXPECT_EQ(count[2], 616);
}

TEST(ChoosePixelsTest, TheSameSeedChoosesTheSameAndAnotherOthers) {
  const auto indices = [](uint32_t seed) {
    std::vector<uint32_t> result;
    for (const ChosenPixel& pixel : ChoosePixels(Picture(), 64, seed)) result.push_back(pixel.index);
    return result;
  };
  EXPECT_EQ(indices(5), indices(5));
  EXPECT_NE(indices(5), indices(6));
}

TEST(EstimateErrorTest, WorkedByHand) {
  // Errors against the mean of both: .1, .05, 0 (lit), weights 1, 3, 10.
  const std::vector<CertifiedPixel> pixels = {{1, 0, 0.5, 0.42, 0.38}, {3, 0, 0.25, 0.3, 0.3}, {10, 1, 1, 1, 1}};
  const Certificate certificate = EstimateError(pixels, 1);
  EXPECT_EQ(certificate.pixels, 3u);
  EXPECT_EQ(certificate.shadowed, 2u);
  EXPECT_NEAR(*certificate.measured, (0.1 + 3 * 0.05) / 4, 1e-12);
  EXPECT_NEAR(certificate.noise, 0.02 / 4, 1e-12);
  EXPECT_NEAR(certificate.rmse_all, std::sqrt((0.08 * 0.12 + 3 * 0.0025) / 14), 1e-12);
  EXPECT_FALSE(certificate.IsLimitedByNoise());
  // Draws of one pixel alone are .1 and .05: the interval holds both.
  EXPECT_NEAR(certificate.ci95, 0.1 - *certificate.measured, 1e-12);
}

TEST(EstimateErrorTest, WithoutShadowThereIsNoFigure) {
  EXPECT_FALSE(EstimateError({}, 1).measured);
  const Certificate lit = EstimateError({{1, 0, 0.5, 1, 1}}, 1);
  EXPECT_FALSE(lit.measured);
  EXPECT_NEAR(lit.rmse_all, 0.5, 1e-12);  // a wrong shadow is seen here
}

// A render without any error, rays with noise .05: the interval reaches 0, and says why it is wide.
TEST(EstimateErrorTest, NoiseOfTheRaysIsNotTakenForError) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.05);
  std::vector<CertifiedPixel> pixels;
  for (int i = 0; i < 1000; ++i) pixels.push_back({1, 0, 0.5, 0.5 + noise(random), 0.5 + noise(random)});
  const Certificate certificate = EstimateError(pixels, 1);
  EXPECT_LE(*certificate.measured - certificate.ci95, 0);
  EXPECT_TRUE(certificate.IsLimitedByNoise());
  EXPECT_LT(certificate.rmse_all, 0.02);
}

// A plate over a ground; the render is what 1024 rays see, but for a row of squares in the shadow that it calls light.
class PlantedLeakTest : public testing::Test {
 protected:
  static constexpr int kSide = 128;

  Certificate Certify(bool leaks) {
    const FlatScene flat = MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8)});
    const auto scene = *RayScene::Create(flat, *BuildPose(flat, flat.default_scene),
                                         [](const EncodedImage&) { return absl::UnimplementedError("no masks"); });
    AreaLight light;
    light.center_ws = {0, 2, 0};
    light.axis_v_ws = {0, 0, 1};
    light.normal_ws = {0, -1, 0};
    light.width_m = light.height_m = 0.5;
    std::vector<glm::vec3> points;
    for (int i = 0; i < kSide * kSide; ++i) {
      points.emplace_back(4 * ((i % kSide + 0.5) / kSide - 0.5), 0, 4 * ((i / kSide + 0.5) / kSide - 0.5));
    }
    const CpuReceivers receivers = MakePointReceivers(points, std::vector<glm::vec3>(points.size(), {0, 1, 0}));
    const auto go_on = [] { return absl::OkStatus(); };
    const TracedLight seen = *TraceLight(*scene, light, receivers, {.rays = 1024}, go_on);
    Image pairs(receivers.width, receivers.height, 2);
    double error = 0;
    int shadowed = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const bool is_leak = leaks && seen.visibility[i] < 0.5f && i / kSide % 16 == 0 && i % 2 == 0;
      pairs.data()[2 * i] = is_leak ? 1 : seen.visibility[i];
      pairs.data()[2 * i + 1] = 1;
      error += is_leak ? 1 - seen.visibility[i] : 0;
      shadowed += seen.visibility[i] < 1 - 1.0f / 512;
    }
    true_error_ = error / shadowed;
    const auto chosen = ChoosePixels(pairs, 2048, 5);
    return EstimateError(*CertifyPixels(*scene, light, receivers, chosen, pairs, 256, 0, go_on), 5);
  }

  double true_error_ = 0;
};

TEST_F(PlantedLeakTest, IsSeen) {
  const Certificate certificate = Certify(true);
  EXPECT_GT(true_error_, 0.01);
  EXPECT_NEAR(*certificate.measured, true_error_, certificate.ci95);
  EXPECT_GT(*certificate.measured - certificate.ci95, 0);
}

TEST_F(PlantedLeakTest, WithoutItTheErrorIsTheNoiseOfTheRays) {
  const Certificate certificate = Certify(false);
  EXPECT_LT(*certificate.measured, 0.002);
  EXPECT_LE(*certificate.measured - certificate.ci95, 0);
  EXPECT_TRUE(certificate.IsLimitedByNoise());
}

}  // namespace
}  // namespace halfshade
