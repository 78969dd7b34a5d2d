// One GL context and renderer per process for tests that draw, and requests to start from.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "renderer/gl/context.h"
#include "renderer/renderer.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {

// The renderer of the process's one test context (HALFSHADE_TEST_GL: auto, egl or osmesa). Never null: aborts with the
// context's error.
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

// Every method that is registered, with options that suit a test: named for gtest.
struct TestMethod {
  std::string name;
  MethodOptions options;
};
inline void PrintTo(const TestMethod& method, std::ostream* out) { *out << method.name; }
std::vector<TestMethod> TestMethods();
inline std::string TestMethodName(const testing::TestParamInfo<TestMethod>& info) { return info.param.name; }

}  // namespace halfshade
