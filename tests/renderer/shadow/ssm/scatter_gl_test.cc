// The scatter of the paper against its equations in double, and what 16-bit floats make of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "renderer/shadow/ssm/scatter.h"
#include "tests/support/closed_forms.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

constexpr double kNear = 0.5;

// Slopes -.8 to .8 from the point of the light; patches are empty.
BinnedMap EmptyMap(int patches, int texels_per_patch, const glm::dvec2& point) {
  BinnedMap map;
  map.point = point;
  map.texels_per_patch = texels_per_patch;
  map.map_size = patches * texels_per_patch;
  map.slope_per_texel = glm::dvec2(1.6 / map.map_size);
  map.first_center = glm::dvec2(-0.8) + 0.5 * map.slope_per_texel;
  map.z_near = kNear;
  map.depths.assign(size_t(map.map_size) * map.map_size + BinnedMap::kPadding, 0);
  return map;
}

// Slopes -1 to 1 from the light's centre.
ReceiverMap Grid(int size) {
  ReceiverMap grid;
  grid.receivers.width = grid.receivers.height = size;
  grid.window = {-1, -1, 1, 1};
  grid.light_z.assign(size_t(size) * size, 0);
  return grid;
}

struct Drawn {
  ScatterSums sums;
  double longest_predicted_ms = 0;
};

Drawn Draw(const BinnedMap& map, const glm::dvec2& half_edges, const ReceiverMap& grid,
           SsmBlend blend = SsmBlend::kFp32) {
  gl::ProgramCache programs(&TestContext());
  gl::Pacer pacer(TestContext(), [] { return absl::OkStatus(); });
  const DrawContext draw = {&TestContext(), &programs, &pacer};
  const auto receivers = MakeScatterReceivers(TestContext(), grid);
  EXPECT_OK(receivers);
  auto sums = Scatter(draw, map, half_edges, *receivers, blend);
  EXPECT_OK(sums);
  return {*std::move(sums), pacer.longest_predicted_ms()};
}

double Saturate(double x) { return std::clamp(x, 0.0, 1.0); }

// Sections 3.2, 3.3 and 4.2 of the paper: every patch that stands before a receiver, projected from it on the light.
std::vector<double> Oracle(const BinnedMap& map, const glm::dvec2& half_edges, const ReceiverMap& grid) {
  const int size = grid.receivers.width;
  const int t = map.texels_per_patch;
  std::vector<double> hidden(grid.light_z.size());
  for (size_t i = 0; i < hidden.size(); ++i) {
    const double z = grid.light_z[i];
    if (!(z > 0)) continue;
    const glm::dvec2 u =
        glm::dvec2(grid.window) + (glm::dvec2(double(i % size), double(i / size)) + 0.5) * (2.0 / size);
    for (int row = 0; row < map.map_size / t; ++row) {
      for (int column = 0; column < map.map_size / t; ++column) {
        double sum = 0, covered = 0;
        for (int y = 0; y < t; ++y) {
          for (int x = 0; x < t; ++x) {
            const double depth = map.depths[size_t(row * t + y) * map.map_size + column * t + x];
            sum += depth;
            covered += depth > 0;
          }
        }
        if (covered == 0) continue;
        const double patch_z = kNear * covered / sum;
        if (patch_z >= z) continue;
        double part = covered / (t * t);
        for (int axis = 0; axis < 2; ++axis) {
          const double place = axis == 0 ? column : row;
          const double slope_per_patch = 1.6 / (map.map_size / t);
          double edge[2];
          for (int k = 0; k < 2; ++k) {
            // Positions of patch and receiver, and the light's point on their line, from map.point on.
            const double patch = (-0.8 + (place + k) * slope_per_patch) * patch_z;
            const double receiver = u[axis] * z - map.point[axis];
            edge[k] = (patch * z - receiver * patch_z) / (z - patch_z);
          }
          part *= half_edges[axis] > 0 ? Saturate(edge[1] / (2 * half_edges[axis]) + 0.5) -
                                             Saturate(edge[0] / (2 * half_edges[axis]) + 0.5)
                                       : double(edge[0] <= 0 && edge[1] > 0);
        }
        hidden[i] += part;
      }
    }
  }
  return hidden;
}

struct Case {
  const char* name;
  glm::dvec2 half_edges;
  glm::dvec2 point{0};
  int texels_per_patch = 1;
};

class ScatterTest : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Lights, ScatterTest,
                         testing::Values(Case{"narrow", glm::dvec2(0.02)}, Case{"wide", glm::dvec2(0.6)},
                                         Case{"oblong", {0.5, 0.01}}, Case{"line", {0.2, 0}},
                                         Case{"sub_light", {0.1, 0.2}, {0.3, -0.4}},
                                         Case{"coverage", glm::dvec2(0.1), {-0.1, 0.2}, 2}),
                         [](const auto& param) { return param.param.name; });

// Receivers from before to far behind the patches, and none at places: extents taken from one depth would be too small.
TEST_P(ScatterTest, AddsWhatTheEquationsSayAtEveryDepthOfReceivers) {
  const Case& c = GetParam();
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(0, 1);
  BinnedMap map = EmptyMap(24, c.texels_per_patch, c.point);
  for (int i = 0; i < map.map_size * map.map_size; ++i) {
    if (any(random) < 0.4) map.depths[i] = float(kNear / (0.6 + 0.9 * any(random)));
  }
  ReceiverMap grid = Grid(60);
  for (size_t i = 0; i < grid.light_z.size(); ++i) {
    const double slope = double(i % 60) / 60;
    if (any(random) < 0.95) grid.light_z[i] = float(i / 60 % 20 == 7 ? 9 : 1 + 1.5 * slope + 0.1 * any(random));
  }
  const std::vector<double> truth = Oracle(map, c.half_edges, grid);
  const Drawn drawn = Draw(map, c.half_edges, grid);
  double largest = 0, worst = 0;
  int off = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    largest = std::max(largest, truth[i]);
    const double d = std::abs(drawn.sums.hidden[i] - truth[i]);
    worst = std::max(worst, d);
    off += d > 1e-4;
  }
  std::printf("%s: largest difference %.2g, largest sum %.3f, %d off\n", c.name, worst, largest, off);
  EXPECT_GT(largest, 0.3);
  // A line's edge is a step: floats may decide otherwise within 1e-3 of a patch of it.
  EXPECT_LE(off, c.half_edges.y > 0 ? 0 : int(truth.size() / 100));
  EXPECT_LE(drawn.longest_predicted_ms, gl::Pacer::kMaxSubmissionMs);
}

TEST(ScatterPlateTest, APlateCastsItsTrapezoid) {
  BinnedMap map = EmptyMap(64, 1, glm::dvec2(0));
  for (int y = 16; y < 48; ++y) {
    for (int x = 16; x < 48; ++x) map.depths[size_t(y) * 64 + x] = float(kNear / 1.0);  // z = 1, up to .4
  }
  ReceiverMap grid = Grid(64);
  grid.light_z.assign(grid.light_z.size(), 2);
  for (const double half_edge : {0.1, 0.5}) {
    const Drawn drawn = Draw(map, glm::dvec2(half_edge), grid);
    for (int i = 0; i < 64 * 64; ++i) {
      const glm::dvec2 u = glm::dvec2(i % 64, i / 64) * (2.0 / 64) - 1.0 + 1.0 / 64;
      const double truth =
          1 - VisibilityBehindPlate(glm::dvec2(half_edge), {0, 0, 1}, {0.4, 0.4}, glm::dvec3(2.0 * u, 2));
      ASSERT_NEAR(drawn.sums.hidden[i], truth, 2e-5) << half_edge << " at " << i;
    }
  }
}

// Each patch hides 1/3844 of the light: too little for 16 bits beside a sum near 1. Batches add numbers that are alike.
TEST(ScatterBlendTest, HalvesLoseSmallPatchesAndBatchesKeepThem) {
  BinnedMap map = EmptyMap(64, 1, glm::dvec2(0));
  for (int y = 1; y < 63; ++y) {
    for (int x = 1; x < 63; ++x) map.depths[size_t(y) * 64 + x] = float(kNear / 1.0);  // z = 1
  }
  ReceiverMap grid = Grid(16);
  grid.light_z.assign(grid.light_z.size(), 2);
  grid.window = {-0.05, -0.05, 0.05, 0.05};
  const glm::dvec2 half_edges(1.4);  // a window of .7, that the patches cover
  double middle[3], least_width = 0;
  for (const SsmBlend blend : {SsmBlend::kFp32, SsmBlend::kFp16, SsmBlend::kFp16Batched}) {
    const Drawn drawn = Draw(map, half_edges, grid, blend);
    middle[int(blend)] = drawn.sums.hidden[8 * 16 + 8];
    least_width = drawn.sums.least_width;
    EXPECT_EQ(drawn.sums.patches, 62u * 62);
    EXPECT_LE(drawn.longest_predicted_ms, gl::Pacer::kMaxSubmissionMs);
  }
  std::printf("sums that are 1: FP32 %.5f, FP16 %.3f, FP16_BATCHED %.4f; a patch hides 1/%.0f of the width\n",
              middle[int(SsmBlend::kFp32)], middle[int(SsmBlend::kFp16)], middle[int(SsmBlend::kFp16Batched)],
              1 / least_width);
  EXPECT_NEAR(least_width, 1 / (2 * 1.4 * 0.5 / 0.025), 1e-6);
  EXPECT_LT(least_width, kLeastWidthFp16) << "eq. 4 is broken";
  EXPECT_NEAR(middle[int(SsmBlend::kFp32)], 1, 1e-4);
  EXPECT_LT(middle[int(SsmBlend::kFp16)], 0.9);
  EXPECT_NEAR(middle[int(SsmBlend::kFp16Batched)], 1, 0.06);
  // From 1/32 of the width on halves hold what the paper promises of them.
  const Drawn wide = Draw(map, glm::dvec2(0.3), grid, SsmBlend::kFp16);
  EXPECT_GT(wide.sums.least_width, kLeastWidthFp16);
  EXPECT_NEAR(wide.sums.hidden[8 * 16 + 8], 1, 0.06);
}

TEST(ScatterReceiversTest, WithoutReceiversOrPatchesNothingIsHidden) {
  const BinnedMap empty = EmptyMap(16, 1, glm::dvec2(0));
  BinnedMap full = EmptyMap(16, 1, glm::dvec2(0));
  ReceiverMap grid = Grid(8);
  EXPECT_EQ(Draw(empty, glm::dvec2(0.1), grid).sums.hidden, std::vector<float>(64));
  grid.light_z.assign(64, 2);
  EXPECT_EQ(Draw(empty, glm::dvec2(0.1), grid).sums.hidden, std::vector<float>(64));
  full.depths.assign(full.depths.size(), float(kNear));
  grid.light_z.assign(64, 0);
  EXPECT_EQ(Draw(full, glm::dvec2(0.1), grid).sums.hidden, std::vector<float>(64));
  // Receivers that are nearer to the light than every patch.
  grid.light_z.assign(64, 0.4f);
  EXPECT_EQ(Draw(full, glm::dvec2(0.1), grid).sums.hidden, std::vector<float>(64));
}

}  // namespace
}  // namespace halfshade
