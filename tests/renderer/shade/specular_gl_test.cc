// The shading of lights against double precision, and energy.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "renderer/math/form_factor.h"
#include "renderer/math/horizon.h"
#include "renderer/math/light_frame.h"
#include "renderer/shade/ltc/ltc_table.h"
#include "tests/renderer/shade/shade_fixture.h"
#include "tests/renderer/shade/specular_truth.h"

namespace halfshade {
namespace {

constexpr double kBaseColor = 0.5;
// The G-buffer's half floats, which llvmpipe truncates: a step of 2^-11 where the colour falls just short of its value.
constexpr double kHalfStep = 1.0 / 2048;

FlatScene Plate(double roughness, double metallic, double base_color = kBaseColor, double size = 64) {
  FlatScene scene = TexturedPlate(size);
  scene.materials[0].roughness = float(roughness);
  scene.materials[0].metallic = float(metallic);
  scene.materials[0].base_color = glm::vec4(glm::vec3(float(base_color)), 1);
  return scene;
}

// At `center`, turned toward the origin and about its normal.
AreaLight LightTowardOrigin(const glm::dvec3& center, double turn, double width, double height) {
  AreaLight light;
  light.center_ws = center;
  light.normal_ws = -glm::normalize(center);
  const glm::dvec3 side = glm::normalize(glm::cross(light.normal_ws, glm::dvec3(0.3, 0.8, 0.52)));
  light.axis_u_ws = side * std::cos(turn) + glm::cross(light.normal_ws, side) * std::sin(turn);
  light.axis_v_ws = glm::cross(light.normal_ws, light.axis_u_ws);
  light.width_m = width;
  light.height_m = height;
  light.radiance = light.intensity = glm::vec3(1);
  return light;
}

RenderRequest Request(const Camera& camera, const AreaLight& light, int n = 12) {
  RenderRequest request = LookDownOn(1, n);
  request.camera = camera;
  request.lights = {light};
  request.outputs = {OutputKind::kFrame, OutputKind::kVisibility};
  return request;
}

glm::dvec3 Ray(const RenderRequest& request, int x, int y) {
  const Camera& camera = request.camera;
  const double ndc_x = 2 * (x + 0.5) / request.width - 1, ndc_y = 1 - 2 * (y + 0.5) / request.height;
  return glm::normalize(camera.forward_ws + (ndc_x * camera.right_ws + ndc_y * camera.up_ws) * camera.tan_half_fovy);
}

// What the plate's pixel reflects, in double, of the light that is above its horizon; `visibility` counts what is below
// too.
double Expected(const RenderRequest& request, int x, int y, double roughness, double metallic, double visibility) {
  const AreaLight& light = request.lights[0];
  const LightFrame frame = MakeLightFrame(light);
  const glm::dvec3 ray = Ray(request, x, y);
  const glm::dvec3 hit = request.camera.eye_ws - ray * (request.camera.eye_ws.y / ray.y);
  SurfacePoint point;
  point.position = PointToLight(frame, hit);
  point.normal = frame.light_from_world_rotation * glm::dvec3(0, 1, 0);
  point.view = frame.light_from_world_rotation * -ray;
  point.roughness = roughness;
  point.f0 = glm::mix(0.04, kBaseColor, metallic);
  if (point.position.z <= 0) return 0;
  const glm::dvec2 half_edges(light.width_m / 2, light.height_m / 2);
  const double share = ShareAbovePlane(half_edges, point.normal, glm::dot(point.normal, point.position));
  if (share == 0) return 0;
  const double seen = visibility / share;
  const LtcEntry entry = InterpolateLtc(roughness, -ray.y);
  const double again = MultipleScattering(entry, point.f0);
  const double albedo = SpecularAlbedo(entry, point.f0) * again;
  const double diffuse = kBaseColor * (1 - metallic) * (1 - albedo) / M_PI;
  if (light.width_m == 0 && light.height_m == 0) {
    return seen * (diffuse * PointIrradiance(point.position, point.normal) + again * SpecularOfPoint(point));
  }
  return seen * (diffuse * RectangleIrradiance(half_edges, point.position, point.normal) +
                 again * SpecularByTable(half_edges, point));
}

class SpecularGlTest : public ShadeTest {
 protected:
  // Largest difference to double precision over the pixels, relative to the brightest; where all see but the tail of a
  // lobe, to `dark`, which is as bright as they need be for their difference to count.
  double Compare(const RenderRequest& request, double roughness, double metallic, double dark = 0) {
    const std::vector<RenderedImage> images = Render(Plate(roughness, metallic), request);
    if (images.size() != 2) return 1e9;
    double worst = 0, largest = dark;
    for (int y = 0; y < request.height; ++y) {
      for (int x = 0; x < request.width; ++x) {
        if (images[0].image.at(x, y, 3) == 0) continue;
        const double expected = Expected(request, x, y, roughness, metallic, images[1].image.at(x, y, 0));
        const double value = images[0].image.at(x, y, 1);
        EXPECT_TRUE(std::isfinite(value) && value >= 0) << value;
        worst = std::max(worst, std::abs(value - expected));
        largest = std::max(largest, expected);
      }
    }
    return largest > 0 ? worst / largest : worst;
  }
};

TEST_F(SpecularGlTest, RectanglesReflectWhatTheTableSaysInDouble) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  double worst = 0;
  for (int i = 0; i < 60; ++i) {
    const double roughness = std::round(1 + 63 * unit(random)) / 64;  // a half float holds it
    const double metallic = i % 2;
    const glm::dvec3 eye(4 * unit(random) - 2, 0.2 + 3 * unit(random), 4);
    const glm::dvec3 center(6 * unit(random) - 3, 0.5 + 3 * unit(random), 4 * unit(random) - 4);
    const AreaLight light = LightTowardOrigin(center, 6 * unit(random), 0.1 + 2 * unit(random), 0.1 + 2 * unit(random));
    worst = std::max(worst, Compare(Request(LookFrom(eye, {0, 0, 0}), light), roughness, metallic, 1e-3));
  }
  std::printf("rectangles: largest difference to double %.2g of the brightest pixel\n", worst);
  EXPECT_LE(worst, kHalfStep + 4e-4);  // measured with colours in floats: 3.6e-4
}

// The light shrinks to 1e-4 of the distance: its power goes with its area, nothing jumps, nothing cancels.
TEST_F(SpecularGlTest, SmallRectanglesKeepTheirPrecision) {
  double worst = 0;
  for (const double edge : {1e-1, 1e-2, 1e-3, 3e-4}) {
    for (const double roughness : {0.125, 0.5, 1.0}) {
      const AreaLight light = LightTowardOrigin({1, 2, -2}, 0.4, edge, 2 * edge);
      worst = std::max(worst, Compare(Request(LookFrom({0, 2, 3}, {0, 0, 0}), light), roughness, 1));
    }
  }
  std::printf("small rectangles: largest difference to double %.2g of the brightest pixel\n", worst);
  // An edge of 3e-4 of the distance leaves the sum of its edges 3e-4 of its terms: with colours in floats 4.8e-4.
  EXPECT_LE(worst, kHalfStep + 5e-4);
}

TEST_F(SpecularGlTest, PointsReflectByTheBrdf) {
  double worst = 0;
  for (const double roughness : {0.125, 0.5, 1.0}) {
    for (const double metallic : {0.0, 1.0}) {
      const AreaLight light = LightTowardOrigin({1, 2, -2}, 0, 0, 0);
      worst = std::max(worst, Compare(Request(LookFrom({0, 2, 3}, {0, 0, 0}), light), roughness, metallic));
    }
  }
  std::printf("points: largest difference to double %.2g of the brightest pixel\n", worst);
  EXPECT_LE(worst, kHalfStep + 1e-5);  // measured with colours in floats: 6.9e-6
}

// A line is the limit of strips of the same intensity.
TEST_F(SpecularGlTest, LinesReflectAsThinRectangles) {
  const double length = 1.5, width = 0.004;
  for (const double metallic : {0.0, 1.0}) {
    for (const double roughness : {0.25, 0.5, 1.0}) {
      const RenderRequest thin =
          Request(LookFrom({0, 2, 3}, {0, 0, 0}), LightTowardOrigin({1, 2, -2}, 0.4, length, width), 16);
      RenderRequest line = thin;
      line.lights[0].height_m = 0;
      line.lights[0].intensity = glm::vec3(float(length * width));
      const FlatScene scene = Plate(roughness, metallic);
      const Image a = RenderFrame(scene, thin);
      const Image b = RenderFrame(scene, line);
      float largest = 0, worst = 0;
      for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
          largest = std::max(largest, a.at(x, y, 0));
          worst = std::max(worst, std::abs(a.at(x, y, 0) - b.at(x, y, 0)));
        }
      }
      EXPECT_GT(largest, 0);
      EXPECT_LE(worst, 0.01 * largest) << roughness;  // a strip of 1/256 against one of 1/750 of the distance
    }
  }
}

TEST_F(SpecularGlTest, ScalingByAPowerOfTwoChangesNoBit) {
  const auto render = [&](double scale, bool is_line) {
    AreaLight light = LightTowardOrigin(glm::dvec3(1, 2, -2) * scale, 0.4, 1.5 * scale, is_line ? 0 : 0.5 * scale);
    light.intensity *= float(scale * scale);  // irradiance falls with the square of the distance
    const RenderRequest request = Request(LookFrom(glm::dvec3(0, 2, 3) * scale, {0, 0, 0}), light, 16);
    return RenderFrame(Plate(0.25, 1, kBaseColor, 64 * scale), request);
  };
  for (const bool is_line : {false, true}) {
    const Image one = render(1, is_line);
    EXPECT_GT(*std::max_element(one.data(), one.data() + one.size()), 0.01f);
    for (const int exponent : {-20, -7, 5, 20}) {
      const Image scaled = render(std::ldexp(1.0, exponent), is_line);
      EXPECT_TRUE(std::equal(one.data(), one.data() + one.size(), scaled.data())) << "2^" << exponent;
    }
  }
}

TEST_F(SpecularGlTest, AWhiteFurnaceGetsNoMoreBackThanItGives) {
  float most = 0;
  for (const double roughness : {0.0, 0.05, 0.2, 0.5, 0.8, 1.0}) {
    for (const double metallic : {0.0, 1.0}) {
      for (const double angle_deg : {1.0, 30.0, 60.0, 80.0, 88.0, 89.7}) {
        const double angle = angle_deg * M_PI / 180;
        const glm::dvec3 eye(0, 5 * std::cos(angle), 5 * std::sin(angle));
        // The ambient light is the furnace.
        RenderRequest request = Request(LookFrom(eye, {0, 0, 0}), LightAbove(1, 1), 8);
        request.camera.tan_half_fovy = 0.01;
        request.lights.clear();
        request.shading.ambient = glm::vec3(1);
        const FlatScene white = Plate(roughness, metallic, 1);
        const Image ambient = RenderFrame(white, request);
        // A lamp that fills the sky, seen through.
        request.shading.ambient = glm::vec3(0);
        request.lights = {LightAbove(0.01, 2000)};
        const Image lamp = RenderFrame(white, request);
        for (const Image* image : {&ambient, &lamp}) {
          const float value = image->at(4, 4, 0);
          EXPECT_TRUE(std::isfinite(value));
          EXPECT_GE(value, 0);
          EXPECT_LE(value, 1 + 1e-3) << roughness << " " << metallic << " " << angle_deg;
          most = std::max(most, value);
        }
        // The sky's edge is 1e-5 of a right angle over the horizon; grazing lobes look there.
        if (angle_deg < 85) {
          EXPECT_NEAR(lamp.at(4, 4, 0), ambient.at(4, 4, 0), 5e-3) << roughness << " " << angle_deg;
        }
      }
    }
  }
  std::printf("white furnace: at most %.6f\n", most);
  EXPECT_GT(most, 0.99) << "white reflects nearly all";
}

}  // namespace
}  // namespace halfshade
