// What is PCSS's own: its widths, its skipping, its way out of the map.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/support/closed_forms.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

Image Render(const FlatScene& scene, RenderRequest request, const PcssOptions& options, uint64_t* tiles = nullptr) {
  request.method = options;
  RenderReport report;
  const Image v = RenderVisibility(scene, request, &report);
  EXPECT_GT(v.size(), 0u);
  if (tiles != nullptr) *tiles = ResolveCount(report);
  return v;
}

// Eq. 1 of Buades et al. 2015 with the numbers of its example: the receiver at 15, blockers at 163/20 and 130/17 give
// penumbrae of .840 and .961 of the light's width.
TEST(PcssTest, APenumbraHasTheWidthOfEquationOne) {
  for (const auto& [blocker_z, width] : {std::pair{163.0 / 20, 0.840}, std::pair{130.0 / 17, 0.961}}) {
    constexpr double kLight = 1, kReceiverZ = 15, kView = 3;
    constexpr int kSize = 512;
    // Its edge at x = 0; far wider than any window.
    const FlatScene scene =
        MakeFlatScene({MakePlate({-10, kReceiverZ - blocker_z, 0}, 20, 40), MakePlate({0, 0, 0}, 8, 8)});
    RenderRequest request;
    request.camera = LookDown(1, kView);
    request.width = kSize;
    request.height = 16;
    request.camera.ortho_height_m = kView * 16 / kSize;
    request.lights = {LightAbove(kReceiverZ, kLight)};
    const Image v = Render(scene, request, {4096, 7, 127});
    // The mean's ramp is linear in 127 steps: from .1 to .9 of it are .8 of its width.
    int low = 0, high = 0;
    while (low < kSize && v.at(low, 8, 0) < 0.1f) ++low;
    while (high < kSize && v.at(high, 8, 0) < 0.9f) ++high;
    const double measured = (high - low) * kView / kSize / 0.8;
    std::printf("blockers at %.3f: penumbra %.3f, eq. 1 %.3f\n", blocker_z, measured, width);
    // A pixel and a step at either end, and half a texel of 20 m / 4096 seen at 15 / 8.
    EXPECT_NEAR(measured, width, 2 * (kView / kSize + width / 127) / 0.8);
  }
}

TEST(PcssTest, OfAPlateTheErrorIsSmallForSmallLights) {
  // A square plate of edge .8 at height 1, a square light at height 2, as in PlateTest.
  for (const auto& [light, most] : {std::pair{0.1, 0.006}, std::pair{0.4, 0.015}}) {
    const FlatScene scene = MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 0, 0}, 8, 8)});
    RenderRequest request;
    request.camera = LookDown(0.5, 3.2);
    request.width = request.height = 128;
    request.lights = {LightAbove(2, light)};
    const Image v = Render(scene, request, {1024, 15, 29});
    double sum = 0;
    int shadowed = 0;
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 128; ++x) {
        const glm::dvec3 receiver(((x + 0.5) / 128 - 0.5) * 3.2, ((y + 0.5) / 128 - 0.5) * 3.2, 2);
        const double truth = VisibilityBehindPlate(glm::dvec2(light / 2), {0, 0, 1}, {0.4, 0.4}, receiver);
        if (truth >= 1 - 1.0 / 512) continue;
        sum += std::abs(v.at(x, y, 0) - truth);
        ++shadowed;
      }
    }
    std::printf("light %.1f: mae_shadowed %.5f\n", light, sum / shadowed);
    ASSERT_GT(shadowed, 1000);
    // Of one depth the blocker average is exact; what is left are taps: a 29th of the penumbra's share of the shadow.
    EXPECT_LE(sum / shadowed, most);
  }
}

class SkipTest : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Scenes, SkipTest, testing::Values("S1", "S2", "S3", "S5", "S6"));

TEST_P(SkipTest, SkippingChangesNoBitAndResolvesFewerTiles) {
  const MadeScene made = MakeScene(GetParam(), {.triangles = GetParam() == "S6" ? 20000u : 0u, .light_share = 0.2});
  const FlatScene scene = MakeFlatScene(made.meshes);
  RenderRequest request = RequestFor(made);
  request.width = 250;  // no whole number of tiles
  request.height = 141;
  for (const FilterWeights weights : {FilterWeights::kMean, FilterWeights::kGaussian}) {
    uint64_t all = 0, resolved = 0;
    const Image without = Render(scene, request, {512, 7, 15, weights, false}, &all);
    const Image with = Render(scene, request, {512, 7, 15, weights, true}, &resolved);
    EXPECT_EQ(all, 16u * 9);
    EXPECT_GT(resolved, 0u);
    EXPECT_LT(resolved, all / 2) << "most of the picture is lit";
    EXPECT_TRUE(std::equal(with.data(), with.data() + with.size(), without.data()));
    // Umbra, penumbra and light are all there.
    EXPECT_EQ(*std::min_element(with.data(), with.data() + with.size()), 0);
    EXPECT_EQ(*std::max_element(with.data(), with.data() + with.size()), 1);
  }
}

// An umbra that is proven dark: the whole window under a wide plate.
TEST(PcssTest, UnderAWidePlateNothingIsResolvedAndAllIsDark) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 1, 0}, 6, 6), MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request;
  request.camera = LookDown(0.5, 1);
  request.width = request.height = 64;
  request.lights = {LightAbove(2, 0.4)};
  uint64_t tiles = 1;
  const Image v = Render(scene, request, {512, 7, 15}, &tiles);
  EXPECT_EQ(tiles, 0u);
  EXPECT_EQ(*std::max_element(v.data(), v.data() + v.size()), 0);
}

// Both filters spread the edge of a half plane as far: the variance of the light's width over 12, in metres on the
// receiver half way.
TEST(PcssTest, AGaussiansPenumbraHasTheVarianceOfTheRectangles) {
  constexpr int kSize = 256;
  constexpr double kView = 1.2, kLight = 0.5;
  const FlatScene scene = MakeFlatScene({MakePlate({-10, 1, 0}, 20, 40), MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request;
  request.camera = LookDown(0.5, kView * 16 / kSize);
  request.width = kSize;
  request.height = 16;
  request.lights = {LightAbove(2, kLight)};
  for (const FilterWeights weights : {FilterWeights::kMean, FilterWeights::kGaussian}) {
    const Image v = Render(scene, request, {4096, 31, 63, weights});
    double weight = 0, mean = 0, square = 0;
    for (int i = 1; i < kSize; ++i) {  // the ramp's slope as a distribution
      const double x = (double(i) / kSize - 0.5) * kView, rise = v.at(i, 8, 0) - v.at(i - 1, 8, 0);
      weight += rise;
      mean += rise * x;
      square += rise * x * x;
    }
    ASSERT_NEAR(weight, 1, 1e-6);
    const double deviation = std::sqrt(square - mean * mean);
    std::printf("deviation %.4f, of the light %.4f\n", deviation, kLight / std::sqrt(12));
    // A texel of 10 mm on the receiver, of 20 m / 4096 seen half way, on .144 m.
    EXPECT_NEAR(deviation, kLight / std::sqrt(12), 0.03 * kLight / std::sqrt(12));
  }
}

TEST(PcssTest, GaussianAndMeanAgreeInTheMiddleOfAPenumbraAndDifferInItsTails) {
  const FlatScene scene = MakeFlatScene({MakePlate({-10, 1, 0}, 20, 40), MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request;
  request.camera = LookDown(0.5, 1);
  request.width = request.height = 65;
  request.lights = {LightAbove(2, 0.5)};
  const Image mean = Render(scene, request, {2048, 7, 31, FilterWeights::kMean});
  const Image gaussian = Render(scene, request, {2048, 7, 31, FilterWeights::kGaussian});
  EXPECT_NEAR(mean.at(32, 32, 0), 0.5, 0.05);
  EXPECT_NEAR(gaussian.at(32, 32, 0), 0.5, 0.05);
  // A quarter of the penumbra's width (.5 m) off the middle: .75 of the mean; of a Gaussian that is cut at two
  // deviations and is as wide in its own .5 + .5 erf(x / sqrt(2)) / erf(sqrt(2)), x deviations off: .79.
  const int x = 32 + int(std::lround(0.125 * 65));
  EXPECT_NEAR(mean.at(x, 32, 0), 0.75, 0.05);
  EXPECT_NEAR(gaussian.at(x, 32, 0), 0.5 + 0.5 * std::erf(0.125 / 0.164 / std::sqrt(2.0)) / std::erf(std::sqrt(2.0)),
              0.02);
}

}  // namespace
}  // namespace halfshade
