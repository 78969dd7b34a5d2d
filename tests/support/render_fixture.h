// One GL context and renderer per process for tests that draw, and requests to start from.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "renderer/gl/context.h"
#include "renderer/renderer.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {

// What HALFSHADE_TEST_GL (auto, egl or osmesa) asks for.
gl::ContextOptions TestContextOptions();
// The renderer of the process's one test context. Never null: aborts with the context's error.
Renderer& TestRenderer();
gl::Context& TestContext();

// A square light of edge `size` above (center_x, height, center_z), shining down.
AreaLight LightAbove(double height, double size, glm::dvec2 center_xz = {0, 0});

// Looks from eye to target, 40 degrees high.
Camera LookFrom(glm::dvec3 eye, glm::dvec3 target);

// An orthographic camera straight down on the square of edge size_m around the origin: pixel (x, y) sees
// world ((x + .5)/n - .5) size_m along x and ((y + .5)/n - .5) size_m along z.
Camera LookDown(double height, double size_m);

// Visibility of the request's lights, drawn by the test renderer; the test fails and the image is empty on an error.
Image RenderVisibility(const FlatScene& scene, RenderRequest request, RenderReport* report = nullptr);

// What resolving the first light counted (OcclusionSum::count): rays, tiles.
uint64_t ResolveCount(const RenderReport& report);

// A method under test. A new one costs a row in TestMethods and a row of thresholds in tests/accuracy.
struct TestMethod {
  std::string name;       // proto field name, for gtest
  MethodOptions options;  // quick
  // At which its own sampling no longer matters much, where that is not `options`: what is left is its model.
  std::optional<MethodOptions> fine = std::nullopt;
  int fine_samples = 0;  // points on the light that `fine` looks from; 0: it does not sample the light
  // By how much `fine` may be off for want of samples or taps on a rectangle along the light's axes.
  double fine_step = 0;
  // Samples of `options` that a receiver shares the pattern of with those beside it: asked as a point it has others.
  int shared_samples = 0;
  std::vector<MethodOptions> others = {};  // at the ends of their ranges and between, each quick at small pictures

  const MethodOptions& Fine() const { return fine ? *fine : options; }
};
inline void PrintTo(const TestMethod& method, std::ostream* out) { *out << method.name; }
// One of each that is registered (tests/stress has the test that says so).
std::vector<TestMethod> TestMethods();
// SSM through a soft shadow map, gathered and as its paper prints it: what casts gets no shadow, so these have tests of
// their own, over something that does not cast.
std::vector<TestMethod> SoftShadowMapForms();
inline std::string TestMethodName(const testing::TestParamInfo<TestMethod>& info) { return info.param.name; }

}  // namespace halfshade
