// Visibility against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "renderer/math/horizon.h"
#include "renderer/math/light_frame.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

RenderRequest Request(const AreaLight& light, const Camera& camera, const MethodOptions& method, int size = 128) {
  RenderRequest request;
  request.camera = camera;
  request.width = request.height = size;
  request.lights = {light};
  request.method = method;
  return request;
}

// Hidden share of [-light/2, light/2] at height H, behind [-plate/2, plate/2] at height h, from x at height 0.
double HiddenShare(double x, double light, double plate, double plate_height, double light_height) {
  const double t = plate_height / light_height;
  const double low = (-plate / 2 - x * (1 - t)) / t;
  const double high = (plate / 2 - x * (1 - t)) / t;
  return std::max(0.0, std::min(high, light / 2) - std::max(low, -light / 2)) / light;
}

struct PlateError {
  double mae_shadowed = 0;
  double max = 0;
  int shadowed = 0;
};

// A square plate of edge .8 at height 1 over a plane, under a square light at height 2.
PlateError MeasurePlate(const MethodOptions& method, double light_size, int size) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 0, 0}, 8, 8)});
  Camera camera = LookDown(0.5, 3.2);  // below the plate: sees the plane alone
  const Image v = RenderVisibility(scene, Request(LightAbove(2, light_size), camera, method, size));
  PlateError error;
  if (v.size() == 0) return error;
  double sum = 0;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double wx = ((x + 0.5) / size - 0.5) * 3.2;
      const double wz = ((y + 0.5) / size - 0.5) * 3.2;
      const double truth = 1 - HiddenShare(wx, light_size, 0.8, 1, 2) * HiddenShare(wz, light_size, 0.8, 1, 2);
      const double difference = std::abs(v.at(x, y, 0) - truth);
      error.max = std::max(error.max, difference);
      if (truth >= 1 - 1.0 / 512) continue;
      sum += difference;
      ++error.shadowed;
    }
  }
  error.mae_shadowed = sum / error.shadowed;
  return error;
}

TEST(PlateTest, MultiMapConvergesToTheClosedForm) {
  for (const double light_size : {0.1, 0.4, 1.0}) {
    const PlateError error = MeasurePlate(MultiMapOptions{256, 1024}, light_size, 128);
    std::printf("light %.2f k 256 maps 1024: mae_shadowed %.5f max %.5f\n", light_size, error.mae_shadowed, error.max);
    EXPECT_GT(error.shadowed, 1000);
    // Scrambled Sobol, k = 256: an axis-aligned edge splits 16 x 16 strata, 1/256 at most twice over, and texels of h ~
    // 2e-3 move an edge by half of one.
    EXPECT_LE(error.mae_shadowed, 6e-3) << light_size;
  }
}

// What the accuracy suite asks of the brute force: as good as any map can be.
TEST(PlateTest, AThousandMapsAreWithinTwoThousandths) {
  const PlateError error = MeasurePlate(MultiMapOptions{1024, 2048}, 0.4, 64);
  std::printf("light 0.40 k 1024 maps 2048: mae_shadowed %.5f max %.5f\n", error.mae_shadowed, error.max);
  EXPECT_LE(error.mae_shadowed, 2e-3);
}

TEST(PlateTest, HardShadowIsTheClosedFormOfAPoint) {
  // Half of the pixels within a texel of the silhouette may fall on either side: 4 edges of 1.6 m over 3.2 m / 128
  // pixels are 256 pixels of 4096 shadowed, texels are .4 of a pixel.
  const FlatScene scene = MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 0, 0}, 8, 8)});
  const Image v = RenderVisibility(scene, Request(LightAbove(2, 0.0), LookDown(0.5, 3.2), HardOptions{1024}));
  ASSERT_GT(v.size(), 0u);
  int wrong = 0;
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) {
      const double wx = ((x + 0.5) / 128 - 0.5) * 3.2;
      const double wz = ((y + 0.5) / 128 - 0.5) * 3.2;
      const bool is_shadowed = std::abs(wx) < 0.8 && std::abs(wz) < 0.8;
      wrong += std::abs(v.at(x, y, 0) - (is_shadowed ? 0.0f : 1.0f)) > 0;
    }
  }
  EXPECT_LE(wrong, 128);
}

class EveryMethodTest : public testing::TestWithParam<TestMethod> {};
INSTANTIATE_TEST_SUITE_P(Methods, EveryMethodTest, testing::ValuesIn(TestMethods()), TestMethodName);

// A lone plane cannot shadow itself at any slope: no acne without tuning. Where it has part of the light below its
// horizon, visibility is the share above.
TEST_P(EveryMethodTest, ALonePlaneHasNoAcneAtAnySlope) {
  double worst = 0;
  for (const double slope_deg : {0.0, 10.0, 30.0, 45.0, 60.0, 75.0, 85.0, 88.0, 89.0, 89.5, 89.9}) {
    for (const double light_size : {0.05, 0.5, 5.0}) {
      const double slope = slope_deg * M_PI / 180;
      const FlatScene scene = MakeFlatScene({MakeSquare({0.013, 0, 0.007}, 1, slope)});
      const AreaLight light = LightAbove(3, light_size);
      // From the normal's side, a little off it.
      const glm::dvec3 normal(-std::sin(slope), std::cos(slope), 0);
      const Camera camera = LookFrom(normal * 3.0 + glm::dvec3(0.3, 0.2, 0.5), {0, 0, 0});
      const RenderRequest request = Request(light, camera, GetParam().options, 96);
      const Image v = RenderVisibility(scene, request);
      ASSERT_GT(v.size(), 0u);
      const LightFrame frame = MakeLightFrame(light);
      const glm::dvec3 n = frame.light_from_world_rotation * normal;
      const double share = ShareAbovePlane({light_size / 2, light_size / 2}, n,
                                           glm::dot(n, PointToLight(frame, glm::dvec3(0.013, 0, 0.007))));
      double occlusion = 0;
      for (int y = 0; y < 96; ++y) {
        for (int x = 0; x < 96; ++x) {
          // Undrawn pixels are 1 by contract.
          if (v.at(x, y, 0) < 1) occlusion = std::max(occlusion, share - v.at(x, y, 0));
        }
      }
      if (share == 1) {
        EXPECT_LE(occlusion, 1e-3) << "slope " << slope_deg << " light " << light_size;
        worst = std::max(worst, occlusion);
      } else if (std::holds_alternative<MultiMapOptions>(GetParam().options)) {
        // The horizon cuts the light: the sampled share is as good as k = 32 stratified points are.
        EXPECT_LE(occlusion, 2.0 / 32 + 1e-3) << "slope " << slope_deg << " light " << light_size;
      }
    }
  }
  std::printf("%s: largest occlusion of a lone plane %.2g\n", GetParam().name.c_str(), worst);
}

// A lone convex solid shadows itself only by its horizon.
TEST_P(EveryMethodTest, ALoneSphereSeesTheShareOfTheLightAboveItsHorizon) {
  if (std::holds_alternative<HardOptions>(GetParam().options)) return;  // a hard shadow has no shares
  const FlatScene scene = MakeFlatScene({MakeSphere({0, 0, 0}, 1, 64)});
  const AreaLight light = LightAbove(3, 1.5);
  const Camera camera = LookFrom({4, 2, 3}, {0, 0, 0});
  const bool is_multi_map = std::holds_alternative<MultiMapOptions>(GetParam().options);
  const MethodOptions options = is_multi_map ? MultiMapOptions{256, 512} : GetParam().options;
  const RenderRequest request = Request(light, camera, options, 160);
  const Image v = RenderVisibility(scene, request);
  ASSERT_GT(v.size(), 0u);
  const LightFrame frame = MakeLightFrame(light);
  double worst = 0;
  int partial = 0;
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 160; ++x) {
      // The facet's plane is near the sphere's: compare with the smooth sphere, loosely at the horizon's edge.
      const double ndc_x = 2 * (x + 0.5) / 160 - 1, ndc_y = 1 - 2 * (y + 0.5) / 160;
      const glm::dvec3 ray =
          glm::normalize(camera.forward_ws + (ndc_x * camera.right_ws + ndc_y * camera.up_ws) * camera.tan_half_fovy);
      const double b = glm::dot(camera.eye_ws, ray);
      const double discriminant = b * b - glm::dot(camera.eye_ws, camera.eye_ws) + 1;
      if (discriminant < 0.02) continue;
      const glm::dvec3 point = camera.eye_ws + ray * (-b - std::sqrt(discriminant));
      const glm::dvec3 n = frame.light_from_world_rotation * glm::normalize(point);
      const double share = ShareAbovePlane({0.75, 0.75}, n, glm::dot(n, PointToLight(frame, point)));
      partial += share > 0.01 && share < 0.99;
      worst = std::max(worst, std::abs(v.at(x, y, 0) - share));
    }
  }
  std::printf("sphere: %d pixels with a cut light, largest difference %.4f\n", partial, worst);
  EXPECT_GT(partial, 500);
  // Facets of 64 rings turn the plane by up to 1/64 rad / 2 from the sphere's: about .05 of a light that spans .5 rad.
  EXPECT_LE(worst, 0.08);
}

TEST_P(EveryMethodTest, WithoutAnOccluderVisibilityIsExactlyOne) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 8, 8)});
  const Image v = RenderVisibility(scene, Request(LightAbove(2, 0.5), LookDown(1, 3), GetParam().options, 64));
  ASSERT_GT(v.size(), 0u);
  EXPECT_EQ(*std::min_element(v.data(), v.data() + v.size()), 1);
}

TEST_P(EveryMethodTest, UnderAFullOccluderVisibilityIsZero) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 1, 0}, 40, 40), MakePlate({0, 0, 0}, 8, 8)});
  const Image v = RenderVisibility(scene, Request(LightAbove(2, 0.5), LookDown(0.5, 3), GetParam().options, 64));
  ASSERT_GT(v.size(), 0u);
  EXPECT_EQ(*std::max_element(v.data(), v.data() + v.size()), 0);
}

TEST_P(EveryMethodTest, BehindAOneSidedLightVisibilityIsZero) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 3, 0}, 8, 8)});
  const Image v =
      RenderVisibility(scene, Request(LightAbove(2, 0.5), LookFrom({1, 0, 1}, {0, 3, 0}), GetParam().options, 64));
  ASSERT_GT(v.size(), 0u);
  EXPECT_EQ(v.at(32, 32, 0), 0);
}

TEST_P(EveryMethodTest, GeometryThroughTheLightsPlaneStillOccludes) {
  // A wall from below to above the light, between it and the receiver beyond: the side windows must see it.
  GlbMesh wall = MakeBox({1, 1.5, 0}, {0.1, 3, 20});
  const FlatScene scene = MakeFlatScene({wall, MakePlate({0, 0, 0}, 80, 80)});
  // At x = 19 the light stands at slope 18.5 / 1.
  Camera camera = LookDown(0.5, 2);
  camera.eye_ws.x = camera.target_ws.x = 19;
  const Image v = RenderVisibility(scene, Request(LightAbove(1, 0.5), camera, GetParam().options, 32));
  ASSERT_GT(v.size(), 0u);
  EXPECT_EQ(*std::max_element(v.data(), v.data() + v.size()), 0);
}

TEST_P(EveryMethodTest, TheSameRequestGivesTheSameBytes) {
  const FlatScene scene = MakeFlatScene({MakeSphere({0, 1, 0}, 0.5, 16), MakePlate({0, 0, 0}, 8, 8)});
  const RenderRequest request = Request(LightAbove(3, 1), LookFrom({3, 3, 3}, {0, 0, 0}), GetParam().options, 96);
  const Image a = RenderVisibility(scene, request);
  const Image b = RenderVisibility(scene, request);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_TRUE(std::equal(a.data(), a.data() + a.size(), b.data()));
}

TEST_P(EveryMethodTest, ScalingByAPowerOfTwoChangesNoBit) {
  const auto render = [&](double scale) {
    const FlatScene scene = MakeFlatScene(
        {MakeSphere(glm::dvec3(0, 1, 0) * scale, 0.5 * scale, 16), MakePlate({0, 0, 0}, 8 * scale, 8 * scale)});
    const Camera camera = LookFrom(glm::dvec3(3, 3, 3) * scale, {0, 0, 0});
    return RenderVisibility(scene, Request(LightAbove(3 * scale, scale), camera, GetParam().options, 96));
  };
  const Image one = render(1);
  for (const int exponent : {-20, -7, 5, 20}) {
    const Image scaled = render(std::ldexp(1.0, exponent));
    ASSERT_EQ(one.size(), scaled.size());
    int different = 0;
    for (size_t i = 0; i < one.size(); ++i) different += one.data()[i] != scaled.data()[i];
    EXPECT_EQ(different, 0) << "2^" << exponent;
  }
}

}  // namespace
}  // namespace halfshade
