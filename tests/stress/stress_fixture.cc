#include "tests/stress/stress_fixture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/gtc/matrix_transform.hpp>

namespace halfshade {

namespace {

const char kPlaneError[] =
    "what is not above a receiver's plane by 4 ulps and the plane's own error, 4 ulps of its distances to light and "
    "eye, hides nothing: 12 ulps, and they hold";
const char kTexelWidth[] =
    "a surface in a crease would shadow itself: what is nearer to a receiver than a map's texel is wide hides nothing";
const char kOnePoint[] = "one point of the light makes no penumbra";

}  // namespace

const std::map<std::string, std::string>& WhatMethodsCannot() {
  static const std::map<std::string, std::string> cannot = {
      {"light touching a box/ray",
       "a segment ends at the light's place in floats: what is within 4 ulps of it is not met"},
      {"light touching a box/shaft",
       "within 2^-20 of the occluders' largest coordinate of the light's plane they are cut away, so that a "
       "lamp's own surface does not hide it"},
      {"near planes, 4 ulps/hard", kPlaneError},
      {"near planes, 4 ulps/multi_map", kPlaneError},
      {"near planes, 4 ulps/pcss", kPlaneError},
      {"near planes, 4 ulps/ray", kPlaneError},
      {"near planes, 4 ulps/ssm", kPlaneError},
      {"near planes, 4 ulps/sssm", kPlaneError},
      {"near planes, 4 ulps/shaft", kPlaneError},
      {"contact penumbra/hard", kOnePoint},
      {"parallel plate/hard", kOnePoint},
      {"near planes/pdsm", kTexelWidth},
      {"near planes, 4 ulps/pdsm", kTexelWidth},
      {"contact penumbra/pdsm", "under three texels wide it is as much wider as its rays are interpolated"},
      {"lone solid/hard", "where its one point is below the horizon it says dark, though part of the light is above"},
      {"contact penumbra/ssm",
       "a sub-light's edge stands on a texel of its own: of four across, a penumbra of 5 may be a tenth narrower"},
      {"broken triangles/ssm", "a T-junction moves a depth by an ulp, and a window with it: 1.3e-6"},
      {"sets of occluders/ssm", "what one view of each of 2 x 2 sub-lights does not see of a second set: .06"},
      {"turned light/ssm",
       "depths of a turned map differ by an ulp, and with it what stands a quarter of a texel above a plane: 4e-6"},
      {"sets of occluders/ssm_map", "as ssm"},
      {"turned light/ssm_scatter_batched",
       "batches follow the map's rows: turned they are others, and 16-bit sums round otherwise: .004"},
      {"sets of occluders/pcss",
       "blockers are averaged: a second occluder moves the depth that the first is filtered at, and a search with 7 x "
       "7 "
       "taps misses what a fuller one finds"},
      {"sets of occluders/sssm", "as pcss: blockers are averaged"},
      {"turned light/sssm",
       "rows lie along u and are shared along v: where blockers of several depths meet, the average comes from other "
       "pixels"},
      {"turned light/pcss", "a tap on a texel's border falls to either side: two of 3969 taps, in one or two pixels"},
  };
  return cannot;
}

std::vector<GlbMesh> StillMeshes() {
  return {MakeSphere({-0.3, 1, 0}, 0.5, 16), MakeBox({0.9, 0.4, 0.2}, {0.3, 0.8, 0.35}), MakePlate({0, 0, 0}, 8, 8)};
}

View Still(double light_size) {
  return {MakeFlatScene(StillMeshes()), LookFrom({3, 3, 3}, {0, 0.3, 0}), LightAbove(3, light_size, {0.4, 0.3})};
}

View Moved(View view, const glm::dmat4& move, double scale) {
  const glm::dmat4 world = move * glm::scale(glm::dmat4(1), glm::dvec3(scale));
  for (const uint32_t root : view.scene.scenes[0].roots) {
    view.scene.nodes[root].local = world * view.scene.nodes[root].local;
  }
  const auto point = [&](glm::dvec3& p) { p = glm::dvec3(world * glm::dvec4(p, 1)); };
  const auto axis = [&](glm::dvec3& a) { a = glm::dvec3(move * glm::dvec4(a, 0)); };
  Camera& camera = view.camera;
  point(camera.eye_ws);
  point(camera.target_ws);
  for (glm::dvec3* a : {&camera.right_ws, &camera.up_ws, &camera.forward_ws}) axis(*a);
  camera.near_m *= scale;
  camera.far_m *= scale;
  camera.ortho_height_m *= scale;
  AreaLight& light = view.light;
  point(light.center_ws);
  for (glm::dvec3* a : {&light.axis_u_ws, &light.axis_v_ws, &light.normal_ws}) axis(*a);
  light.width_m *= scale;
  light.height_m *= scale;
  return view;
}

Difference Between(const Image& a, const Image& b, double bound) {
  Difference difference;
  if (a.size() != b.size() || a.size() == 0) {
    difference.is_finite = false;
    return difference;
  }
  for (size_t i = 0; i < a.size(); ++i) {
    const double d = std::abs(double(a.data()[i]) - double(b.data()[i]));
    if (!std::isfinite(d)) difference.is_finite = false;
    difference.max = std::max(difference.max, d);
    difference.mean += d / double(a.size());
    difference.share_over += double(d > bound) / double(a.size());
  }
  return difference;
}

std::string Text(const Difference& d) {
  char text[120];
  std::snprintf(text, sizeof(text), "mean %.2g, max %.2g, over the bound %.3f %%", d.mean, d.max, 100 * d.share_over);
  return text;
}

bool IsInRange(const Image& image) {
  return image.size() > 0 &&
         std::all_of(image.data(), image.data() + image.size(), [](float v) { return v >= 0 && v <= 1; });
}

Image DrawStill(const MethodOptions& method) { return StressTest::Render(Still(), method); }

Image DrawStillOnANewContext(const MethodOptions& method) {
  const auto no_textures = [](const EncodedImage&) { return absl::UnimplementedError("these tests have no textures"); };
  const View view = Still();
  RenderRequest request = StressTest::RequestFor(view, method, kStressSize);
  request.outputs = {OutputKind::kVisibility};
  auto context = gl::Context::Create(TestContextOptions());
  EXPECT_OK(context);
  if (!context.ok()) return Image();
  auto renderer = Renderer::Create(context->get(), no_textures);
  EXPECT_OK(renderer);
  if (!renderer.ok()) return Image();
  auto result = (*renderer)->Render("still", view.scene, request, [] { return absl::OkStatus(); });
  EXPECT_OK(result);
  return result.ok() ? std::move(result->images[0].image) : Image();
}

Image QueryStill(const MethodOptions& method) {
  const View view = Still();
  QueryPoints points;
  for (int y = 0; y < kStressSize; ++y) {
    for (int x = 0; x < kStressSize; ++x) {
      points.points_ws.emplace_back(4 * ((x + 0.5) / kStressSize - 0.5), 0, 4 * ((y + 0.5) / kStressSize - 0.5));
      points.normals_ws.emplace_back(0, 1, 0);
    }
  }
  const auto result = TestRenderer().QueryVisibility(
      "still", view.scene, StressTest::RequestFor(view, method, kStressSize), points, [] { return absl::OkStatus(); });
  EXPECT_OK(result);
  if (!result.ok()) return Image();
  Image image(kStressSize, kStressSize, 1);
  std::copy(result->visibility.begin(), result->visibility.end(), image.data());
  return image;
}

RenderRequest StressTest::RequestFor(const View& view, const MethodOptions& method, int size) {
  RenderRequest request;
  request.camera = view.camera;
  request.width = request.height = size;
  request.lights = {view.light};
  request.method = method;
  return request;
}

Image StressTest::Render(const View& view, const MethodOptions& method, int size, uint32_t seed) {
  RenderRequest request = RequestFor(view, method, size);
  request.seed = seed;
  return RenderVisibility(view.scene, request);
}

void StressTest::Row(const std::string& row, bool holds, const std::string& figure) {
  std::printf("%s, %s: %s%s\n", row.c_str(), GetParam().name.c_str(), figure.c_str(), holds ? "" : " (does not hold)");
  std::string& failure = failures_[row];
  if (!holds && failure.empty()) failure = figure;
}

void StressTest::LightGrows() {
  size_t last_umbra = size_t(kStressSize) * kStressSize, last_penumbra = 0;
  bool holds = true;
  std::string figure;
  for (const double size : {0.05, 0.2, 0.8, 1.6}) {
    const Image v = Render(Still(size));
    const size_t umbra = size_t(std::count_if(v.data(), v.data() + v.size(), [](float x) { return x <= 1.0f / 512; }));
    const size_t penumbra = size_t(
        std::count_if(v.data(), v.data() + v.size(), [](float x) { return x > 1.0f / 512 && x < 1 - 1.0f / 512; }));
    holds = holds && umbra <= last_umbra && penumbra >= last_penumbra;
    figure += std::to_string(umbra) + "/" + std::to_string(penumbra) + " ";
    last_umbra = umbra;
    last_penumbra = penumbra;
  }
  Row("growing light", holds, "umbra/penumbra pixels " + figure);
}

void StressTest::SetsOfOccluders(const Image& of_a, const Image& of_b, const Image& of_both) {
  double over = 0, under = 0;
  for (size_t i = 0; i < of_both.size(); ++i) {
    const double oa = 1 - of_a.data()[i], ob = 1 - of_b.data()[i], both = 1 - of_both.data()[i];
    over = std::max(over, both - std::min(1.0, oa + ob));
    under = std::max(under, std::max(oa, ob) - both);
  }
  Row("sets of occluders", of_both.size() > 0 && over <= 0.01 && under <= 0.01,
      "over the sum " + std::to_string(over) + ", under the larger " + std::to_string(under));
}

void StressTest::TearDown() {
  for (const auto& [row, failure] : failures_) {
    const auto cannot = WhatMethodsCannot().find(row + "/" + GetParam().name);
    if (cannot == WhatMethodsCannot().end()) {
      EXPECT_EQ(failure, "") << row;
    } else {
      EXPECT_NE(failure, "") << row << " holds now: take it out of WhatMethodsCannot (" << cannot->second << ")";
    }
  }
}

}  // namespace halfshade
