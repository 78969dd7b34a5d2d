// PENUMBRA_WIDTH of the methods that know it, against eq. 1 of Buades et al. 2015.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "renderer/light/occluders.h"
#include "renderer/scene/pose.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

struct Images {
  Image visibility, width;
};

Images Render(const FlatScene& scene, RenderRequest request) {
  request.outputs = {OutputKind::kVisibility, OutputKind::kPenumbraWidth};
  auto result = TestRenderer().Render("test", scene, request, [] { return absl::OkStatus(); });
  TestRenderer().ForgetScene("test");
  EXPECT_OK(result);
  if (!result.ok()) return {};
  return {std::move(result->images[0].image), std::move(result->images[1].image)};
}

SssmOptions Sssm(int blocker_taps, int filter_taps, int sub_lights) {
  SssmOptions options{2048, blocker_taps, filter_taps, FilterWeights::kMean};
  options.sub_lights = sub_lights;
  return options;
}

// Buades et al. 2015, Table 5: the mean squared difference of SSSM's width from that of PCSS, whose rows are its own,
// in texels of the map.
struct SharingCase {
  const char* scene;
  int blocker_taps, filter_taps;
  float threshold;
  double bound;  // squared texels
};
class SharedWidthTest : public testing::TestWithParam<SharingCase> {};
// Leaves hold blockers at all depths, and a shared row knows but three of them; coarse rows miss single leaves besides.
INSTANTIATE_TEST_SUITE_P(Kernels, SharedWidthTest,
                         testing::Values(SharingCase{"S2", 29, 41, 0.1f, 0.05}, SharingCase{"S5", 11, 21, 0.1f, 0.25},
                                         SharingCase{"S5", 29, 41, 0.01f, 0.2}, SharingCase{"S5", 29, 41, 0.1f, 0.2},
                                         SharingCase{"S5", 29, 41, 0.5f, 0.2}));

TEST_P(SharedWidthTest, IsCloseToThatOfOwnRows) {
  constexpr int kMapSize = 1024;
  const SharingCase& sharing = GetParam();
  const MadeScene made = MakeScene(sharing.scene, {.light_share = 0.1});
  const FlatScene scene = MakeFlatScene(made.meshes);
  RenderRequest request = RequestFor(made);
  request.width = 640;
  request.height = 360;
  request.outputs = {OutputKind::kPosition};
  request.method = HardOptions{64};
  auto positions = TestRenderer().Render("test", scene, request, [] { return absl::OkStatus(); });
  ASSERT_OK(positions);
  request.method = PcssOptions{kMapSize, sharing.blocker_taps, sharing.filter_taps};
  const Images own = Render(scene, request);
  SssmOptions options = Sssm(sharing.blocker_taps, sharing.filter_taps, 1);
  options.map_size = kMapSize;
  options.alpha = options.beta = sharing.threshold;
  request.method = options;
  const Images shared = Render(scene, request);

  const AreaLight& light = request.lights[0];
  auto pose = BuildPose(scene, 0, {});
  ASSERT_OK(pose);
  const Window window = BuildLightSpaceOccluders(scene, *pose, light).hull.FrontWindow({0, 0});
  const double slope_per_texel = std::max(window.u1 - window.u0, window.v1 - window.v0) / (kMapSize - 2);
  double sum = 0;
  int count = 0;
  for (size_t i = 0; i < own.width.size(); ++i) {
    // Where one of them sees no blocker it has no width.
    if (own.width.data()[i] == 0 || shared.width.data()[i] == 0) continue;
    const float* p = positions->images[0].image.data() + 3 * i;
    const double z = glm::dot(glm::dvec3(p[0], p[1], p[2]) - light.center_ws, light.normal_ws);
    const double texels = (own.width.data()[i] - shared.width.data()[i]) / (z * slope_per_texel);
    sum += texels * texels;
    ++count;
  }
  ASSERT_GT(count, 1000);
  std::printf("%s, %d/%d, alpha = beta = %g: %.3f texels^2 over %d pixels\n", sharing.scene, sharing.blocker_taps,
              sharing.filter_taps, sharing.threshold, sum / count, count);
  EXPECT_LE(sum / count, sharing.bound);
}

class PenumbraWidthTest : public testing::TestWithParam<TestMethod> {};
INSTANTIATE_TEST_SUITE_P(Methods, PenumbraWidthTest,
                         testing::Values(TestMethod{.name = "pcss", .options = PcssOptions{2048, 13, 21}},
                                         TestMethod{.name = "sssm", .options = Sssm(13, 21, 1)},
                                         TestMethod{.name = "sssm_2x2", .options = Sssm(13, 21, 2)}),
                         TestMethodName);

// The paper's numbers: receiver at 15, blockers at 163/20 and 130/17 on average: .840 and .961 of the light's width.
TEST_P(PenumbraWidthTest, IsEquationOneInThePenumbraAndZeroInUmbraAndLight) {
  for (const auto& [blocker_z, width] : {std::pair{163.0 / 20, 0.8405}, std::pair{130.0 / 17, 0.9615}}) {
    constexpr int kSize = 96;
    const FlatScene scene = MakeFlatScene({MakePlate({-10, 15 - blocker_z, 0}, 20, 40), MakePlate({0, 0, 0}, 8, 8)});
    RenderRequest request;
    request.method = GetParam().options;
    request.camera = LookDown(1, 3);
    request.width = request.height = kSize;
    AreaLight light = LightAbove(15, 2);  // its longer edge counts
    light.height_m = 0.5;
    request.lights = {light};
    const Images images = Render(scene, request);
    ASSERT_EQ(images.width.size(), size_t(kSize) * kSize);
    int penumbra = 0;
    for (int i = 0; i < kSize * kSize; ++i) {
      const float v = images.visibility.data()[i];
      if (v <= 1.0f / 512 || v >= 1 - 1.0f / 512) {
        ASSERT_EQ(images.width.data()[i], 0) << "v = " << v;
      } else {
        ++penumbra;
        ASSERT_NEAR(images.width.data()[i], 2 * width, 2e-3) << "v = " << v;  // the paper's digits
      }
    }
    EXPECT_GT(penumbra, kSize * kSize / 4);
  }
}

// Rows of 40 over 4 and of 6 over 1 average 9.2 by the sum of sums over the sum of counts; the mean of the rows'
// averages, as the paper prints it, would be 8. Above one receiver at 15, of 13 x 13 taps within half a light's width
// times (1/6 - 1/15): four of a row at 10, one of another at 6.
TEST(BlockerAverageTest, IsTheSumOfSumsOverTheSumOfCounts) {
  const double half_window = 0.5 * (1.0 / 6 - 1.0 / 15);  // slopes
  const double step = half_window / 6;
  // A rectangle at depth z that covers the taps [x0, x1] of rows [y0, y1], to the middles between taps.
  const auto cover = [&](double z, int x0, int x1, int y0, int y1) {
    const glm::dvec2 low = (glm::dvec2(x0, y0) - 0.5) * step * z, high = (glm::dvec2(x1, y1) + 0.5) * step * z;
    // LightAbove looks down: u is world x, v is world z.
    return MakePlate({(low.x + high.x) / 2, 15 - z, (low.y + high.y) / 2}, high.x - low.x, high.y - low.y);
  };
  const FlatScene scene = MakeFlatScene({cover(10, -2, 1, 0, 0), cover(6, 0, 0, 2, 2), MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request;
  // One receiver matters: the pixel in the middle.
  request.camera = LookDown(0.5, 0.01);
  request.width = request.height = 5;
  request.lights = {LightAbove(15, 1)};
  for (const MethodOptions& method : {MethodOptions(PcssOptions{4096, 13, 41}), MethodOptions(Sssm(13, 41, 1))}) {
    request.method = method;
    const Images images = Render(scene, request);
    ASSERT_GT(images.width.size(), 0u);
    EXPECT_GT(images.visibility.at(2, 2, 0), 0.1f);
    EXPECT_NEAR(images.width.at(2, 2, 0), (15 - 9.2) / 9.2, 1e-3) << "8 would be " << (15.0 - 8) / 8;
  }
}

TEST(PenumbraWidthOutputTest, HasAChannelForEachLightAndComesBesideFramesOfSeveralSamples) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request;
  request.method = Sssm(9, 21, 1);
  request.camera = LookDown(0.5, 3.2);
  request.width = request.height = 64;
  AreaLight dark = LightAbove(3, 0.4);
  dark.radiance = dark.intensity = glm::vec3(0);
  AreaLight both = LightAbove(2, 0.4);
  both.is_two_sided = true;
  request.lights = {LightAbove(2, 0.4), LightAbove(2, 0.8), dark, both};
  const Images alone = Render(scene, request);
  ASSERT_EQ(alone.width.size(), 64u * 64 * 4);
  // Blockers half way: the penumbra is as wide as the light.
  float widest[4] = {};
  for (size_t i = 0; i < alone.width.size(); ++i) widest[i % 4] = std::max(widest[i % 4], alone.width.data()[i]);
  EXPECT_NEAR(widest[0], 0.4, 1e-3);
  EXPECT_NEAR(widest[1], 0.8, 1e-3);
  EXPECT_NEAR(widest[2], 0.2, 1e-3) << "shadows do not depend on power";
  EXPECT_NEAR(widest[3], 0.4, 1e-3);
  request.outputs = {OutputKind::kFrame, OutputKind::kPenumbraWidth};
  request.samples = 4;
  auto result = TestRenderer().Render("test", scene, request, [] { return absl::OkStatus(); });
  TestRenderer().ForgetScene("test");
  ASSERT_OK(result);
  const Image& beside = result->images[1].image;
  EXPECT_TRUE(std::equal(beside.data(), beside.data() + beside.size(), alone.width.data()));
}

TEST(PenumbraWidthOutputTest, OfAMethodThatDoesNotKnowItIsRefusedByNameBeforeAnythingIsDrawn) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 8, 8)});
  RenderRequest request;
  request.lights = {LightAbove(2, 0.4)};
  request.method = RayOptions{4};
  request.outputs = {OutputKind::kVisibility, OutputKind::kPenumbraWidth};
  const auto is_refused = testing::AllOf(testing::HasSubstr("outputs[1].kind: PENUMBRA_WIDTH is not known to ray"),
                                         testing::HasSubstr("pcss"), testing::HasSubstr("sssm"));
  EXPECT_THAT(TestRenderer().Render("test", scene, request, [] { return absl::OkStatus(); }),
              StatusIs(absl::StatusCode::kUnimplemented, is_refused));
  EXPECT_THAT(PlanRender(scene, request), StatusIs(absl::StatusCode::kUnimplemented, is_refused));
  TestRenderer().ForgetScene("test");
}

}  // namespace
}  // namespace halfshade
