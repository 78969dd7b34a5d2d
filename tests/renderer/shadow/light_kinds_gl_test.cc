// Rectangles, lines, points and two-sided lights: truth in closed form, and what every method owes to every kind.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "renderer/math/form_factor.h"
#include "renderer/math/horizon.h"
#include "renderer/math/light_frame.h"
#include "tests/support/closed_forms.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

AreaLight Sized(AreaLight light, double width, double height, bool is_two_sided = false) {
  light.width_m = width;
  light.height_m = height;
  light.is_two_sided = is_two_sided;
  return light;
}

RenderRequest Request(const AreaLight& light, const Camera& camera, const MethodOptions& method, int size = 64) {
  RenderRequest request;
  request.camera = camera;
  request.width = request.height = size;
  request.lights = {light};
  request.method = method;
  return request;
}

bool Equal(const Image& a, const Image& b) {
  return a.size() == b.size() && a.size() > 0 && std::equal(a.data(), a.data() + a.size(), b.data());
}

// LookDown from under the origin's plane, up: pixel (x, y) sees world x as LookDown does, and z mirrored.
Camera LookUp(double depth, double size_m) {
  Camera camera = LookDown(depth, size_m);
  camera.eye_ws.y = -depth;
  camera.forward_ws.y = 1;
  camera.up_ws.z = 1;
  return camera;
}

constexpr int kSize = 128;
constexpr double kView = 3.2;
double PixelCenter(int i) { return ((i + 0.5) / kSize - 0.5) * kView; }

// Mean error over shadowed pixels of `v`, seen by LookDown or LookUp on the plane y = receiver_y, behind a plate of
// edge .8 around (0, plate_y, 0) under `light`, which is parallel to both.
double MaeShadowed(const Image& v, const AreaLight& light, double plate_y, double receiver_y, int* shadowed) {
  const LightFrame frame = MakeLightFrame(light);
  const glm::dvec3 plate = PointToLight(frame, {0, plate_y, 0});
  double sum = 0;
  *shadowed = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const glm::dvec3 receiver = PointToLight(frame, {PixelCenter(x), receiver_y, PixelCenter(y)});
      const double truth = VisibilityBehindPlate({light.width_m / 2, light.height_m / 2}, plate, {0.4, 0.4}, receiver);
      if (truth >= 1 - 1.0 / 512) continue;
      sum += std::abs(v.at(x, y, 0) - truth);
      ++*shadowed;
    }
  }
  return sum / std::max(1, *shadowed);
}

FlatScene PlateOverFloor() { return MakeFlatScene({MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 0, 0}, 8, 8)}); }

TEST(LineLightTest, BehindAPlateVisibilityIsTheClosedForm) {
  for (const double length : {0.1, 1.0}) {
    for (const bool is_along_u : {true, false}) {
      const AreaLight light = Sized(LightAbove(2, 0), is_along_u ? length : 0, is_along_u ? 0 : length);
      const Image v =
          RenderVisibility(PlateOverFloor(), Request(light, LookDown(0.5, kView), MultiMapOptions{256, 1024}, kSize));
      ASSERT_GT(v.size(), 0u);
      int shadowed = 0;
      const double error = MaeShadowed(v, light, 1, 0, &shadowed);
      std::printf("line of %.2f: mae_shadowed %.5f\n", length, error);
      EXPECT_GT(shadowed, 4000);
      // From nowhere are both ends of the plate seen before the line: one edge, which splits one of 256 strata.
      EXPECT_LE(error, 1.0 / 256);
    }
  }
}

TEST(LineLightTest, OnATiltedPlaneVisibilityIsTheShareOfTheLineAboveTheHorizon) {
  const int k = 256;
  for (const double slope_deg : {-80.0, -60.0, 60.0, 80.0}) {
    const double slope = slope_deg * M_PI / 180;
    const FlatScene scene = MakeFlatScene({MakeSquare({0, 0, 0}, 0.01, slope)});
    const AreaLight light = Sized(LightAbove(1, 0), 8, 0);
    const glm::dvec3 normal(-std::sin(slope), std::cos(slope), 0);
    RenderRequest request =
        Request(light, LookFrom(normal * 0.1 + glm::dvec3(0, 0, 0.01), {0, 0, 0}), MultiMapOptions{k, 256}, 9);
    const Image v = RenderVisibility(scene, request);
    ASSERT_GT(v.size(), 0u);
    const LightFrame frame = MakeLightFrame(light);
    const glm::dvec3 n = frame.light_from_world_rotation * normal;
    const double share = ShareAbovePlane({4, 0}, n, glm::dot(n, PointToLight(frame, {0, 0, 0})));
    EXPECT_GT(share, 0.05);
    EXPECT_LT(share, 0.95);
    EXPECT_NEAR(v.at(4, 4, 0), share, 2.0 / k) << slope_deg << ": a stratum may fall on either side, at both ends";
  }
}

TEST(PointLightTest, NeedsOneMapHoweverManyAreAskedFor) {
  for (const AreaLight& light : {Sized(LightAbove(2, 0), 0, 0), Sized(LightAbove(2, 0), 0, 0, true)}) {
    RenderReport report;
    const Camera camera = LookFrom({3, 3, 3}, {0, 0, 0});
    const Image many = RenderVisibility(PlateOverFloor(), Request(light, camera, MultiMapOptions{64, 512}), &report);
    EXPECT_TRUE(Equal(many, RenderVisibility(PlateOverFloor(), Request(light, camera, HardOptions{512}))));
    for (const PassReport& pass : report.passes) {
      if (pass.name == "light[0]/light_data") {
        EXPECT_EQ(pass.count, 1u);
      }
    }
  }
}

// Floor and ceiling, a plate before each; the light between them.
class TwoSidedLightTest : public testing::TestWithParam<TestMethod> {
 protected:
  TwoSidedLightTest()
      : scene_(MakeFlatScene({MakePlate({0, -2, 0}, 8, 8), MakePlate({0, -1, 0}, 0.8, 0.8),
                              MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 2, 0}, 8, 8)})),
        down_(Sized(LightAbove(0, 0), 0.5, 0.3)),
        up_(OtherSide(down_)),
        both_(Sized(down_, 0.5, 0.3, true)) {}

  Image Visibility(const AreaLight& light, const Camera& camera) const {
    return RenderVisibility(scene_, Request(light, camera, GetParam().options));
  }

  FlatScene scene_;
  AreaLight down_, up_, both_;
};
INSTANTIATE_TEST_SUITE_P(Methods, TwoSidedLightTest, testing::ValuesIn(TestMethods()), TestMethodName);

TEST_P(TwoSidedLightTest, EachSideIsTheOneSidedLightToTheBit) {
  Camera on_floor = LookDown(-1.5, kView);
  Camera on_ceiling = LookUp(-1.5, kView);
  on_floor.near_m = on_ceiling.near_m = 1e-3;
  EXPECT_TRUE(Equal(Visibility(both_, on_floor), Visibility(down_, on_floor)));
  EXPECT_TRUE(Equal(Visibility(both_, on_ceiling), Visibility(up_, on_ceiling)));
  const Image dark = Visibility(down_, on_ceiling);
  EXPECT_EQ(*std::max_element(dark.data(), dark.data() + dark.size()), 0);
  // Both in one picture: nothing is lit from both.
  const Camera across = LookFrom({6, 0.3, 1}, {0, 0, 0});
  const Image all = Visibility(both_, across);
  const Image down = Visibility(down_, across), up = Visibility(up_, across);
  ASSERT_EQ(all.size(), down.size());
  int from_below = 0, from_above = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    ASSERT_EQ(all.data()[i], std::max(down.data()[i], up.data()[i]));
    from_above += down.data()[i] > 0 && up.data()[i] == 0;
    from_below += up.data()[i] > 0 && down.data()[i] == 0;
  }
  EXPECT_GT(from_above, 500);
  EXPECT_GT(from_below, 500);
}

TEST_P(TwoSidedLightTest, SharesCountEveryPixelOnce) {
  RenderReport report;
  RenderVisibility(scene_, Request(both_, LookFrom({6, 0.3, 1}, {0, 0, 0}), GetParam().options), &report);
  EXPECT_NEAR(report.share_umbra + report.share_penumbra + report.share_lit, 1, 1e-12);
  EXPECT_GT(report.share_lit, 0.5);
}

TEST(TwoSidedTruthTest, BehindAPlateOnEitherSideVisibilityIsTheClosedForm) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, -2, 0}, 8, 8), MakePlate({0, -1, 0}, 0.8, 0.8),
                                         MakePlate({0, 1, 0}, 0.8, 0.8), MakePlate({0, 2, 0}, 8, 8)});
  const AreaLight light = Sized(LightAbove(0, 0), 0.5, 0.3, true);
  for (const bool is_floor : {true, false}) {
    Camera camera = is_floor ? LookDown(-1.5, kView) : LookUp(-1.5, kView);
    camera.near_m = 1e-3;
    const Image v = RenderVisibility(scene, Request(light, camera, MultiMapOptions{256, 1024}, kSize));
    ASSERT_GT(v.size(), 0u);
    const double side = is_floor ? -1 : 1;
    int shadowed = 0;
    const double error = MaeShadowed(v, is_floor ? light : OtherSide(light), side, 2 * side, &shadowed);
    std::printf("two-sided, %s: mae_shadowed %.5f\n", is_floor ? "front" : "back", error);
    EXPECT_GT(shadowed, 4000);
    EXPECT_LE(error, 6e-3) << "as PlateTest";
  }
}

// Unshadowed light on a white, rough floor and ceiling. Of a dielectric of roughness 1 the specular is 4 % and nearly
// as wide as the diffuse: the whole is Lambert's within 1 % (renderer/shade has the exact truth of each kind).
TEST(ShadedLightTest, AFrameIsTheClosedFormForEveryKindAndBothSides) {
  FlatScene scene = MakeFlatScene({MakePlate({0, -1, 0}, 8, 8), MakePlate({0, 1, 0}, 8, 8)});
  for (Material& material : scene.materials) material.base_color = glm::vec4(1);
  for (const glm::dvec2& edges : {glm::dvec2(0.5, 0.3), glm::dvec2(0.5, 0), glm::dvec2(0, 0.3), glm::dvec2(0)}) {
    for (const bool is_two_sided : {false, true}) {
      AreaLight light = Sized(LightAbove(0, 0), edges.x, edges.y, is_two_sided);
      light.radiance = light.intensity = glm::vec3(2, 3, 5);
      for (const bool is_floor : {true, false}) {
        Camera camera = is_floor ? LookDown(0, kView) : LookUp(0, kView);
        camera.near_m = 1e-3;
        camera.far_m = 10;
        RenderRequest request = Request(light, camera, HardOptions{64}, kSize);
        request.outputs = {OutputKind::kFrame};
        request.shading.ambient = glm::vec3(0);
        const auto result = TestRenderer().Render("shaded", scene, request, [] { return absl::OkStatus(); });
        TestRenderer().ForgetScene("shaded");
        ASSERT_OK(result);
        const LightFrame frame = MakeLightFrame(is_floor ? light : OtherSide(light));
        for (const glm::ivec2& pixel : {glm::ivec2(64, 64), glm::ivec2(100, 40), glm::ivec2(3, 90)}) {
          const glm::dvec3 point = PointToLight(frame, {PixelCenter(pixel.x), is_floor ? -1 : 1, PixelCenter(pixel.y)});
          const glm::dvec2 half = edges * 0.5;
          const glm::dvec3 n(0, 0, -1);
          const double irradiance = edges.x > 0 && edges.y > 0 ? RectangleIrradiance(half, point, n)
                                    : edges.x + edges.y > 0    ? LineIrradiance(half, point, n)
                                                               : PointIrradiance(point, n);
          for (int c = 0; c < 3; ++c) {
            const double truth = is_floor || is_two_sided ? double(light.radiance[c]) * irradiance / M_PI : 0;
            EXPECT_NEAR(result->images[0].image.at(pixel.x, pixel.y, c), truth, 1e-2 * truth + 1e-7)
                << edges.x << " x " << edges.y << (is_floor ? " floor" : " ceiling") << (is_two_sided ? " both" : "");
          }
        }
      }
    }
  }
}

struct LightKind {
  std::string name;
  glm::dvec2 edges;
  bool is_two_sided;
};

class EveryLightTest : public testing::TestWithParam<std::tuple<TestMethod, LightKind>> {
 protected:
  AreaLight LightAt(double height) const {
    const LightKind& kind = std::get<1>(GetParam());
    return Sized(LightAbove(height, 0), kind.edges.x, kind.edges.y, kind.is_two_sided);
  }
  Image Visibility(const std::vector<GlbMesh>& meshes, const AreaLight& light, const Camera& camera) const {
    return RenderVisibility(MakeFlatScene(meshes), Request(light, camera, std::get<0>(GetParam()).options));
  }
  static std::pair<float, float> Range(const Image& v) {
    EXPECT_GT(v.size(), 0u);
    const auto [low, high] = std::minmax_element(v.data(), v.data() + v.size());
    return {*low, *high};
  }
};
INSTANTIATE_TEST_SUITE_P(
    Methods, EveryLightTest,
    testing::Combine(testing::ValuesIn(TestMethods()),
                     testing::Values(LightKind{"rectangle", {0.5, 0.3}, false}, LightKind{"line_u", {0.5, 0}, false},
                                     LightKind{"line_v", {0, 0.5}, false}, LightKind{"point", {0, 0}, false},
                                     LightKind{"two_sided", {0.5, 0.3}, true},
                                     LightKind{"two_sided_line", {0.5, 0}, true},
                                     LightKind{"two_sided_point", {0, 0}, true})),
    [](const auto& row) { return std::get<0>(row.param).name + "_" + std::get<1>(row.param).name; });

TEST_P(EveryLightTest, NothingHidesNothingAndAFullOccluderHidesAll) {
  const std::vector<GlbMesh> floor = {MakePlate({0, 0, 0}, 8, 8)};
  EXPECT_EQ(Range(Visibility(floor, LightAt(2), LookDown(1, 3))), std::pair(1.0f, 1.0f));
  const std::vector<GlbMesh> covered = {MakePlate({0, 1, 0}, 40, 40), MakePlate({0, 0, 0}, 8, 8)};
  EXPECT_EQ(Range(Visibility(covered, LightAt(2), LookDown(0.5, 3))), std::pair(0.0f, 0.0f));
}

TEST_P(EveryLightTest, BehindItIsDarkUnlessItHasTwoSides) {
  const float lit = std::get<1>(GetParam()).is_two_sided ? 1 : 0;
  EXPECT_EQ(Visibility({MakePlate({0, 3, 0}, 8, 8)}, LightAt(2), LookFrom({1, 0, 1}, {0, 3, 0})).at(32, 32, 0), lit);
}

TEST_P(EveryLightTest, IsInRangeAndTheSameTwiceWithGeometryOnAllSidesAndThroughItsPlane) {
  // A room: the light hangs in it, and a column reaches from its floor past the light.
  const std::vector<GlbMesh> room = {MakeBox({0, 0, 0}, {6, 4, 6}), MakeBox({1, 0, 0.5}, {0.3, 4, 0.3}),
                                     MakeSphere({-0.7, -1, 0.3}, 0.5, 12)};
  const Camera camera = LookFrom({2.6, 0.4, 2.6}, {0, -0.5, 0});
  const Image v = Visibility(room, LightAt(0.5), camera);
  for (size_t i = 0; i < v.size(); ++i) ASSERT_TRUE(v.data()[i] >= 0 && v.data()[i] <= 1);
  const auto [low, high] = Range(v);
  EXPECT_EQ(low, 0);
  EXPECT_EQ(high, 1);
  EXPECT_TRUE(Equal(v, Visibility(room, LightAt(0.5), camera)));
}

class CameraKindTest : public testing::TestWithParam<TestMethod> {};
INSTANTIATE_TEST_SUITE_P(Methods, CameraKindTest, testing::ValuesIn(TestMethods()), TestMethodName);

TEST_P(CameraKindTest, AnOrthographicCameraSeesWhatAFarPerspectiveOneSees) {
  // A sphere on a floor, lit aslant, from above. From 1000 m perspective moves what is 1 m high by 1e-3 of its place.
  const FlatScene scene = MakeFlatScene({MakeSphere({0.2, 0.5, 0}, 0.5, 32), MakePlate({0, 0, 0}, 8, 8)});
  const AreaLight light = LightAbove(3, 0.5, {-1, 0.5});
  const Camera near = LookDown(2, kView);
  Camera far = LookDown(1000, kView);
  far.is_orthographic = false;
  far.tan_half_fovy = kView / 2 / 1000;
  far.near_m = 900;
  const Image a = RenderVisibility(scene, Request(light, near, GetParam().options, kSize));
  const Image b = RenderVisibility(scene, Request(light, far, GetParam().options, kSize));
  ASSERT_EQ(a.size(), b.size());
  double sum = 0;
  int shadowed = 0, different = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double difference = std::abs(a.data()[i] - b.data()[i]);
    sum += difference;
    shadowed += a.data()[i] < 1;
    different += difference > 0.1;
  }
  std::printf("%s: mean difference %.5f, over .1 at %d of %zu pixels\n", GetParam().name.c_str(),
              sum / double(a.size()), different, a.size());
  EXPECT_GT(shadowed, 1000);
  // An edge 400 pixels long that moves by 1e-3 of the picture's half, .06 pixels, changes 25 pixels; there are the
  // sphere's, its shadow's and its terminator's.
  EXPECT_LE(different, 80);
  EXPECT_LE(sum / double(a.size()), 80.0 / double(a.size()));
}

TEST(SeedTest, AnotherSeedIsAnotherImageOfTheSameShadow) {
  RenderRequest request = Request(LightAbove(2, 0.4), LookDown(0.5, kView), MultiMapOptions{64, 512}, kSize);
  const Image first = RenderVisibility(PlateOverFloor(), request);
  const Image again = RenderVisibility(PlateOverFloor(), request);
  request.seed = 1;
  const Image other = RenderVisibility(PlateOverFloor(), request);
  EXPECT_TRUE(Equal(first, again));
  EXPECT_FALSE(Equal(first, other));
  for (const Image* v : {&first, &other}) {
    int shadowed = 0;
    // 64 points in 8 x 8 strata: an edge splits 8 of them, each by 1/64 at most, half of that on average.
    EXPECT_LE(MaeShadowed(*v, request.lights[0], 1, 0, &shadowed), 0.5 * 8.0 / 64);
  }
}

}  // namespace
}  // namespace halfshade
