// Fog: against closed forms, against sums in double, and lit by PDSM against rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/renderer/shade/render_image.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

// A floor that reflects nothing but what `ambient` gives it, seen from straight above at a height.
RenderRequest LookDownThrough(const Fog& fog, double height) {
  RenderRequest request;
  request.camera = LookDown(height, 1);
  request.width = request.height = 16;
  request.fog = fog;
  request.method = HardOptions{16};
  request.lights = {LightAbove(50, 0)};
  request.lights[0].intensity = glm::vec3(0);
  request.shading.ambient = glm::vec3(0.5f, 0.25f, 0.125f);
  request.shading.background = glm::vec3(0);
  return request;
}

TEST(FogTest, VeilsTheSceneByItsOpticalDepthAndScattersAmbientLight) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 4, 4)});
  for (const double falloff : {0.0, 1.5}) {
    Fog fog = {.density_per_m = 0.3, .albedo = {0.9f, 0.6f, 0.3f}, .falloff_height_m = falloff, .ground_m = 0.2};
    RenderRequest request = LookDownThrough(fog, 3);
    const Image foggy = RenderImage(scene, request, OutputKind::kFrame);
    request.fog.reset();
    const Image clear = RenderImage(scene, request, OutputKind::kFrame);
    // From the floor at 0 to the eye at 3.
    const double depth = falloff == 0 ? 0.3 * 3 : 0.3 * falloff * (std::exp(0.2 / falloff) - std::exp(-2.8 / falloff));
    const double kept = std::exp(-depth);
    for (int c = 0; c < 3; ++c) {
      const double ambient = request.shading.ambient[c];
      EXPECT_NEAR(foggy.at(8, 8, c), clear.at(8, 8, c) * kept + fog.albedo[c] * ambient * (1 - kept), 2e-5)
          << "falloff " << falloff << ", channel " << c;
    }
    EXPECT_EQ(foggy.at(8, 8, 3), 1);
  }
}

TEST(FogTest, HidesABackgroundWithoutEndAndNothingWhereItIsThin) {
  RenderRequest request = LookDownThrough({.density_per_m = 0.01}, 3);
  request.camera = LookFrom({0, 1, 0}, {10, 1, 0});
  request.shading.background = glm::vec3(1, 2, 3);
  const FlatScene scene = MakeFlatScene({MakePlate({0, -5, 0}, 1, 1)});
  Image frame = RenderImage(scene, request, OutputKind::kFrame);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(frame.at(8, 8, c), request.shading.ambient[c], 1e-5);
  request.fog->density_per_m = 0;
  frame = RenderImage(scene, request, OutputKind::kFrame);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(frame.at(8, 8, c), request.shading.background[c]);
  // Looking up out of a layer, the way through it is finite.
  request.fog = Fog{.density_per_m = 0.1, .falloff_height_m = 2, .ground_m = 1};
  request.camera = LookFrom({0, 1, 0}, {0.01, 5, 0});
  frame = RenderImage(scene, request, OutputKind::kFrame);
  const double kept = std::exp(-0.1 * 2);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(frame.at(8, 8, c), request.shading.background[c] * kept + request.shading.ambient[c] * (1 - kept),
                0.01);
  }
}

// Single scattering along the ray of a pixel, summed in double; the light's points in a fine grid.
double Scattered(const AreaLight& light, const Fog& fog, const glm::dvec3& eye, const glm::dvec3& direction,
                 double length) {
  const auto extinction = [&](double y) {
    return fog.density_per_m * (fog.falloff_height_m > 0 ? std::exp(-(y - fog.ground_m) / fog.falloff_height_m) : 1.0);
  };
  const auto depth = [&](const glm::dvec3& from, const glm::dvec3& to) {
    constexpr int kParts = 50;
    double sum = 0;
    for (int i = 0; i < kParts; ++i) sum += extinction(glm::mix(from, to, (i + 0.5) / kParts).y);
    return sum * glm::length(to - from) / kParts;
  };
  constexpr int kSteps = 2000, kSide = 8;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const glm::dvec3 at = eye + direction * (length * (i + 0.5) / kSteps);
    double fluence = 0;
    const bool is_point = light.width_m == 0;
    for (int j = 0; j < (is_point ? 1 : kSide * kSide); ++j) {
      glm::dvec3 on_light = light.center_ws;
      if (!is_point) {
        on_light += light.axis_u_ws * light.width_m * ((j % kSide + 0.5) / kSide - 0.5) +
                    light.axis_v_ws * light.height_m * ((j / kSide + 0.5) / kSide - 0.5);
      }
      const glm::dvec3 way = at - on_light;
      const double distance = glm::length(way);
      const double cosine = std::max(0.0, glm::dot(way, light.normal_ws) / distance);
      const double emitted = is_point ? 1 : light.width_m * light.height_m / (kSide * kSide);
      fluence += emitted * cosine / (distance * distance);
    }
    sum += extinction(at.y) * std::exp(-depth(eye, at) - depth(light.center_ws, at)) * fluence / (4 * M_PI);
  }
  return sum * length / kSteps;
}

TEST(FogTest, ScattersWhatALightSendsAsASumInDoubleDoes) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 40, 40)});
  for (const double edge : {0.0, 0.8}) {
    for (const double falloff : {0.0, 2.0}) {
      const Fog fog = {.density_per_m = 0.2, .albedo = glm::vec3(1), .falloff_height_m = falloff};
      RenderRequest request = LookDownThrough(fog, 3);
      request.shading.ambient = glm::vec3(0);
      request.lights = {LightAbove(3, edge)};
      request.lights[0].radiance = glm::vec3(edge > 0 ? 1 : 0);
      request.lights[0].intensity = glm::vec3(edge > 0 ? 0 : 1);
      for (const glm::dvec3& target : {glm::dvec3(0, 0.8, 0), glm::dvec3(0.3, 2, 0), glm::dvec3(0, 2.6, -3)}) {
        // All pixels look nearly the same way.
        request.camera = LookFrom({0, 1, 6}, target);
        request.camera.tan_half_fovy = 0.005;
        request.fog->albedo = glm::vec3(1);
        const Image lit = RenderImage(scene, request, OutputKind::kFrame);
        // The floor's own light is taken away: that of the same frame without albedo.
        request.fog->albedo = glm::vec3(0);
        const Image veiled = RenderImage(scene, request, OutputKind::kFrame);
        const glm::dvec3 direction = request.camera.forward_ws;
        const double length = direction.y < 0 ? std::min(100.0, -request.camera.eye_ws.y / direction.y) : 100;
        const double expected = Scattered(request.lights[0], fog, request.camera.eye_ws, direction, length);
        const double got = lit.at(8, 8, 0) - veiled.at(8, 8, 0);
        std::printf("edge %.1f falloff %.0f: %.6f of %.6f\n", edge, falloff, got, expected);
        EXPECT_NEAR(got, expected, 0.02 * expected) << "256 points of a block of 4 x 4 pixels";
      }
    }
  }
}

TEST(FogTest, ShaftsThatPdsmLightsAreThoseOfRays) {
  const MadeScene made = MakeScene("S8");
  const FlatScene scene = MakeFlatScene(made.meshes);
  RenderRequest request = RequestFor(made);
  request.width = 160;
  request.height = 90;
  request.shading.ambient = request.shading.background = glm::vec3(0);
  request.fog =
      Fog{made.fog->density_per_m, glm::vec3(made.fog->albedo), made.fog->falloff_height_m, made.fog->ground_m};
  const auto shafts = [&](const MethodOptions& method) {
    request.method = method;
    request.fog->albedo = glm::vec3(made.fog->albedo);
    Image frame = RenderImage(scene, request, OutputKind::kFrame);
    request.fog->albedo = glm::vec3(0);
    const Image veiled = RenderImage(scene, request, OutputKind::kFrame);
    for (size_t i = 0; i < frame.size(); ++i) frame.data()[i] -= veiled.data()[i];
    return frame;
  };
  const Image truth = shafts(RayOptions{64});
  double mean = 0, unshadowed = 0;
  for (int i = 0; i < 160 * 90; ++i) mean += truth.data()[4 * i] / (160.0 * 90);
  for (NodeOverride change; change.node < 200; ++change.node) {
    if (change.node >= scene.nodes.size()) break;
    change.casts = false;
    request.node_overrides.push_back(change);
  }
  const Image bare = shafts(HardOptions{16});
  request.node_overrides.clear();
  for (int i = 0; i < 160 * 90; ++i) unshadowed += bare.data()[4 * i] / (160.0 * 90);
  for (const PdsmLayout layout : {PdsmLayout::kVolume, PdsmLayout::kIndexed}) {
    PdsmOptions options;
    options.layout = layout;
    if (layout == PdsmLayout::kIndexed) options.construction = PdsmConstruction::kScatter;
    const Image lit = shafts(options);
    double off = 0, bias = 0;
    for (int i = 0; i < 160 * 90; ++i) {
      off += std::abs(lit.data()[4 * i] - truth.data()[4 * i]) / (160.0 * 90);
      bias += (lit.data()[4 * i] - truth.data()[4 * i]) / (160.0 * 90);
    }
    std::printf("layout %d: scattered light off by %.2f %% (bias %.2f %%) of %.5f; without occluders %.5f\n",
                int(layout), 100 * off / mean, 100 * bias / mean, mean, unshadowed);
    // Of what the slats take away, a twentieth.
    EXPECT_LE(off, 0.05 * (unshadowed - mean));
  }
  EXPECT_LT(mean, 0.97 * unshadowed) << "the slats' shadows are in the fog";
}

}  // namespace
}  // namespace halfshade
