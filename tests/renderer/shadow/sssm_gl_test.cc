// What is SSSM's own: rows that pixels share, and where they must not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

Image Render(const FlatScene& scene, RenderRequest request, const MethodOptions& options, uint64_t* tiles = nullptr) {
  request.method = options;
  RenderReport report;
  const Image v = RenderVisibility(scene, request, &report);
  EXPECT_GT(v.size(), 0u);
  if (tiles != nullptr) *tiles = ResolveCount(report);
  return v;
}

struct Difference {
  double max = 0, mean = 0;
};

Difference Compare(const Image& a, const Image& b) {
  Difference difference;
  EXPECT_EQ(a.size(), b.size());
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const double d = std::abs(double(a.data()[i]) - b.data()[i]);
    difference.max = std::max(difference.max, d);
    difference.mean += d / double(a.size());
  }
  return difference;
}

SssmOptions Sssm(int blocker_taps, int filter_taps, float threshold, FilterWeights weights = FilterWeights::kMean) {
  SssmOptions options;
  options.map_size = 512;
  options.blocker_taps = blocker_taps;
  options.filter_taps = filter_taps;
  options.weights = weights;
  options.alpha = options.beta = threshold;
  return options;
}

// Eq. 1 with the numbers of the paper's example, as in PcssTest, through shared rows and columns alike: the edge lies
// along v, then along u.
TEST(SssmTest, APenumbraHasTheWidthOfEquationOne) {
  constexpr double kReceiverZ = 15, kView = 3;
  constexpr int kSize = 512;
  for (const auto& [blocker_z, width] : {std::pair{163.0 / 20, 0.840}, std::pair{130.0 / 17, 0.961}}) {
    for (const bool is_along_u : {false, true}) {
      const double y = kReceiverZ - blocker_z;
      const FlatScene scene = MakeFlatScene(
          {is_along_u ? MakePlate({0, y, -10}, 40, 20) : MakePlate({-10, y, 0}, 20, 40), MakePlate({0, 0, 0}, 8, 8)});
      RenderRequest request;
      request.camera = LookDown(1, kView);
      request.width = is_along_u ? 16 : kSize;
      request.height = is_along_u ? kSize : 16;
      request.camera.ortho_height_m = kView * request.height / kSize;
      request.lights = {LightAbove(kReceiverZ, 1)};
      SssmOptions options = Sssm(7, 127, 0.1f);
      options.map_size = 4096;
      const Image v = Render(scene, request, options);
      const auto at = [&](int i) { return is_along_u ? v.at(8, i, 0) : v.at(i, 8, 0); };
      // The mean's ramp is linear in 127 steps: from .1 to .9 of it are .8 of its width.
      int low = 0, high = 0;
      while (low < kSize && at(low) < 0.1f) ++low;
      while (high < kSize && at(high) < 0.9f) ++high;
      const double measured = (high - low) * kView / kSize / 0.8;
      std::printf("blockers at %.3f: penumbra %.3f, eq. 1 %.3f\n", blocker_z, measured, width);
      // A pixel and a step at either end, as for PCSS.
      EXPECT_NEAR(measured, width, 2 * (kView / kSize + width / 127) / 0.8);
    }
  }
}

class SssmClassTest : public testing::TestWithParam<std::string> {
 protected:
  SssmClassTest() {
    const MadeScene made = MakeScene(GetParam(), {.triangles = GetParam() == "S6" ? 20000u : 0u, .light_share = 0.2});
    scene_ = MakeFlatScene(made.meshes);
    request_ = RequestFor(made);
    request_.width = 250;  // no whole number of tiles
    request_.height = 141;
  }
  FlatScene scene_;
  RenderRequest request_;
};
INSTANTIATE_TEST_SUITE_P(Scenes, SssmClassTest, testing::Values("S1", "S2", "S3", "S4", "S5", "S6"));

// No row is shared: the same taps, summed in another order.
TEST_P(SssmClassTest, WithoutSharingItIsPcss) {
  for (const FilterWeights weights : {FilterWeights::kMean, FilterWeights::kGaussian}) {
    const Image pcss = Render(scene_, request_, PcssOptions{512, 9, 21, weights});
    EXPECT_LE(Compare(pcss, Render(scene_, request_, Sssm(9, 21, 0, weights))).max, 1e-5);
  }
}

TEST_P(SssmClassTest, SkippingChangesNoBitAndResolvesFewerTiles) {
  uint64_t all = 0, resolved = 0;
  SssmOptions options = Sssm(9, 21, 0.1f);
  const Image with = Render(scene_, request_, options, &resolved);
  options.skips = false;
  const Image without = Render(scene_, request_, options, &all);
  EXPECT_EQ(all, 16u * 9);
  EXPECT_GT(resolved, 0u);
  EXPECT_LT(resolved, all / 2) << "most of the picture is lit";
  EXPECT_TRUE(std::equal(with.data(), with.data() + with.size(), without.data()));
}

// What is shared is not what the map gives, and yet close to it; the share of pixels far off is small.
TEST_P(SssmClassTest, SharedRowsAreCloseToOwnOnes) {
  const Image pcss = Render(scene_, request_, PcssOptions{512, 11, 21});
  const Image sssm = Render(scene_, request_, Sssm(11, 21, 0.1f));
  const Difference difference = Compare(pcss, sssm);
  int far = 0;
  for (size_t i = 0; i < pcss.size(); ++i) far += std::abs(pcss.data()[i] - sssm.data()[i]) > 0.1f;
  std::printf("%s: mean difference %.5f, largest %.3f, over .1 at %d pixels\n", GetParam().c_str(), difference.mean,
              difference.max, far);
  EXPECT_GT(difference.mean, 0);
  // A step of 1/21 in the penumbra, which is 2 to 8 % of these pictures.
  EXPECT_LE(difference.mean, 0.08 / 21);
  EXPECT_LE(far, int(pcss.size()) / 1000);
}

// Thresholds count: what lies deeper than alpha and beta allow is not shared, and metres are not fractions.
TEST(SssmTest, ASteepReceiverSharesOnlyWithinTheThreshold) {
  // The ground falls off from the light: over the search of blockers its depth changes by several centimetres.
  // Two plates, so that the average depends on which rows are summed.
  const FlatScene scene = MakeFlatScene(
      {MakePlate({-0.2, 1, 0}, 0.3, 0.8), MakePlate({0.2, 1.2, 0}, 0.3, 0.8), MakeSquare({0, 0, 0}, 4, 0.6)});
  RenderRequest request;
  request.camera = LookDown(0.5, 2);
  request.width = request.height = 96;
  AreaLight light = LightAbove(2, 0.6);
  std::swap(light.axis_u_ws, light.axis_v_ws);  // rows lie across the slope
  light.axis_u_ws = -light.axis_u_ws;
  request.lights = {light};
  const Image pcss = Render(scene, request, PcssOptions{512, 11, 21});
  const auto differs = [&](float threshold, SssmThresholds thresholds) {
    SssmOptions options = Sssm(11, 21, threshold);
    options.beta = 0;
    options.thresholds = thresholds;
    return Compare(pcss, Render(scene, request, options)).mean;
  };
  const double loose = differs(0.5f, SssmThresholds::kRelative);
  const double tight = differs(1e-4f, SssmThresholds::kRelative);
  std::printf("mean difference from PCSS: alpha .5 %.2g, 1e-4 %.2g\n", loose, tight);
  EXPECT_GT(loose, 0);
  EXPECT_LT(tight, loose);
  // At depths of 1.3 to 2.7 metres a fraction is more than as many metres.
  EXPECT_EQ(differs(100, SssmThresholds::kAbsolute), differs(100, SssmThresholds::kRelative));
  EXPECT_NE(differs(0.2f, SssmThresholds::kAbsolute), differs(0.2f, SssmThresholds::kRelative));
}

// Figs. 12 and 13 of the paper: a penumbra that runs across a depth discontinuity and out of the picture.
TEST(SssmTest, NoGhostsBesideDepthDiscontinuitiesAndTheBorder) {
  // A half plane's penumbra crosses a step of the ground of .3 m, which casts nothing; the picture ends inside the
  // penumbra.
  const FlatScene scene = MakeFlatScene(
      {MakePlate({-2, 1.2, 0}, 4, 4), MakePlate({0, 0, 0}, 8, 8), MakeBox({0.3, 0.15, 0.4}, {1.6, 0.3, 0.8})});
  RenderRequest request;
  request.camera = LookFrom({0.5, 2.2, 2.6}, {0.1, 0, 0.3});
  request.width = 320;
  request.height = 180;
  for (const double turn : {0.0, 0.6, M_PI / 2}) {
    AreaLight light = LightAbove(2, 0.5);
    light.axis_u_ws = {std::cos(turn), 0, std::sin(turn)};
    light.axis_v_ws = glm::cross(light.normal_ws, light.axis_u_ws);
    request.lights = {light};
    request.node_overrides = {{.node = 2, .local = {}, .casts = false}};
    const Image pcss = Render(scene, request, PcssOptions{512, 29, 41});
    SssmOptions options = Sssm(29, 41, 0.1f);
    const Difference difference = Compare(pcss, Render(scene, request, options));
    std::printf("turned by %.1f: largest difference %.3f, mean %.5f\n", turn, difference.max, difference.mean);
    EXPECT_LE(difference.max, 0.1);
    EXPECT_GT(difference.mean, 0);
  }
}

TEST(SssmTest, SubLightsOfAPlateConvergeToItsClosedForm) {
  // As PcssTest: the hull of one depth is exact for any number of sub-lights; a box's two depths are not.
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0.75, 0}, {0.5, 0.9, 0.5}), MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request;
  request.camera = LookDown(0.2, 3.2);
  request.width = request.height = 128;
  request.lights = {LightAbove(2, 0.8)};
  const Image truth = Render(scene, request, RayOptions{1024});
  double last = 1;
  for (const int q : {1, 2, 4}) {
    SssmOptions options = Sssm(15, 29, 0.1f);
    options.map_size = 1024;
    options.sub_lights = q;
    const double error = Compare(truth, Render(scene, request, options)).mean;
    std::printf("q = %d: mean error %.5f\n", q, error);
    EXPECT_LT(error, last);
    last = error;
  }
}

}  // namespace
}  // namespace halfshade
