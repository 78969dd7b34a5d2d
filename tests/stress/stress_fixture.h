// The numerical stress table over every registered method: rows, what a method cannot, and the scene that most use.
// README.md has the table.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "tests/support/render_fixture.h"

namespace halfshade {

// What is drawn, and how.
struct View {
  FlatScene scene;
  Camera camera;
  AreaLight light;
};

// A sphere and a box over a plane, seen aslant: curved and straight edges, contact, a concave corner.
View Still(double light_size = 1);
// Its sphere, box and plane.
std::vector<GlbMesh> StillMeshes();
// Scene, camera and light moved by x -> move x, `move` a rotation and a translation, after a uniform scale about the
// world's origin.
View Moved(View view, const glm::dmat4& move, double scale = 1);

struct Difference {
  double mean = 0, max = 0;
  double share_over = 0;  // of pixels that differ by more than the bound
  bool is_finite = true;  // false too where the images differ in size or are empty
};
Difference Between(const Image& a, const Image& b, double bound);
std::string Text(const Difference& difference);
// Every pixel is a number in [0,1], and there are some.
bool IsInRange(const Image& image);

inline constexpr int kStressSize = 96;  // pixels a side

// Still() by a method: by the process's renderer, or by one of a context of its own on the calling thread. Empty on an
// error, and the test fails.
Image DrawStill(const MethodOptions& method);
Image DrawStillOnANewContext(const MethodOptions& method);
// The same scene from a grid of points on its plane, 4 m a side around the origin.
Image QueryStill(const MethodOptions& method);

class StressTest : public testing::TestWithParam<TestMethod> {
 public:
  static RenderRequest RequestFor(const View& view, const MethodOptions& method, int size);
  static Image Render(const View& view, const MethodOptions& method, int size = kStressSize, uint32_t seed = 0);

 protected:
  Image Render(const View& view, int size = kStressSize) { return Render(view, GetParam().options, size); }

  // Prints a figure of a row. A row holds when all of its figures do; it must, unless kCannot (stress_fixture.cc) names
  // it with this method: then it must not.
  void Row(const std::string& row, bool holds, const std::string& figure);
  // Rows of the table that tests of other methods ask too. Pixels in umbra and penumbra while the light grows:
  void LightGrows();
  // What two sets of occluders hide apart and together: at least the larger, at most the sum, by .01.
  void SetsOfOccluders(const Image& of_a, const Image& of_b, const Image& of_both);
  void TearDown() override;

 private:
  std::map<std::string, std::string> failures_;  // row -> its first figure that does not hold, or ""
};

// "row/method" -> why it cannot hold. The same stands in renderer/shadow/README.md.
const std::map<std::string, std::string>& WhatMethodsCannot();

}  // namespace halfshade
