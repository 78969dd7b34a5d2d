#include "renderer/scene/blend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "renderer/scene/ray_mask.h"

namespace halfshade {
namespace {

Mesh MeshIn(const glm::vec3& low, const glm::vec3& high) {
  Mesh mesh;
  mesh.bounds.Add(low);
  mesh.bounds.Add(high);
  return mesh;
}

Instance InstanceOf(uint32_t node, uint32_t mesh, uint32_t place) {
  Instance instance;
  instance.node = node;
  instance.mesh = mesh;
  instance.place = place;
  return instance;
}

Material Blend(float alpha) {
  Material material;
  material.alpha_mode = AlphaMode::kBlend;
  material.base_color.a = alpha;
  return material;
}

// Of n random places on a square.
std::vector<glm::vec3> RandomPlaces(int n) {
  const BlendSpace space(MeshIn({-1, 0, -1}, {1, 0, 1}), InstanceOf(1, 2, 0));
  std::mt19937 random(7);
  const auto uniform = [&] { return float(random()) / 2147483648.0f - 1; };
  std::vector<glm::vec3> places;
  for (int i = 0; i < n; ++i) {
    const float x = uniform();
    places.push_back(space.Place({x, 0, uniform()}));
  }
  return places;
}

TEST(BlendTest, ThresholdsAreUniform) {
  constexpr int kPlaces = 1 << 16, kBins = 64;
  int counts[kBins] = {};
  for (const glm::vec3& place : RandomPlaces(kPlaces)) {
    const float threshold = BlendThreshold(place);
    ASSERT_GT(threshold, 0);
    ASSERT_LT(threshold, 1);
    ++counts[int(threshold * kBins)];
  }
  double chi_square = 0;
  for (const int count : counts)
    chi_square += (count - kPlaces / kBins) * (count - kPlaces / kBins) * kBins / double(kPlaces);
  // 63 degrees of freedom: 103 once in a thousand.
  EXPECT_LT(chi_square, 103);
  EXPECT_GT(chi_square, 33) << "more even than chance";
}

TEST(BlendTest, NeighbouringCellsAreIndependent) {
  // Correlation of thresholds of cells beside each other, along each axis; of n pairs 1/sqrt(n).
  constexpr int kSide = 128;
  for (int axis = 0; axis < 3; ++axis) {
    double sum = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        glm::vec3 a(0.5f);
        a[axis] += float(x);
        a[(axis + 1) % 3] += float(y);
        glm::vec3 b = a;
        b[axis] += 1;
        sum += (BlendThreshold(a) - 0.5) * (BlendThreshold(b) - 0.5) * 12;
      }
    }
    EXPECT_LT(std::abs(sum / (kSide * kSide)), 3.0 / kSide);
  }
}

TEST(BlendTest, ACellHasOneThresholdUpToItsBorders) {
  const float at = BlendThreshold({100.5f, 200.5f, 300.5f});
  for (const float d : {-0.5f, -0.25f, 0.25f, 0.499f})
    EXPECT_EQ(BlendThreshold({100.5f + d, 200.5f, 300.5f - d / 2}), at);
  EXPECT_NE(BlendThreshold({101, 200.5f, 300.5f}), at);
  EXPECT_NE(BlendThreshold({99.99f, 200.5f, 300.5f}), at);
}

TEST(BlendTest, PlacesThatAreNoneAreInSomeCell) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float bad : {-1.0f, 1e30f, kInfinity, -kInfinity, std::nanf("")}) {
    const float threshold = BlendThreshold({bad, 3, bad});
    EXPECT_TRUE(threshold > 0 && threshold < 1) << bad;
  }
}

// Holes are fixed to the mesh: in whatever units it is written, and wherever its node stands.
TEST(BlendTest, CellsAreOfTheMeshAndNotOfTheWorld) {
  Instance moved = InstanceOf(1, 2, 0);
  const BlendSpace here(MeshIn({-1, -1, -1}, {1, 3, 1}), moved);
  moved.world_from_mesh[3] = glm::dvec4(100, 0, 0, 1);
  const BlendSpace there(MeshIn({-1024, -1024, -1024}, {1024, 3072, 1024}), moved);
  const glm::vec3 point(0.25f, 2.5f, -0.75f);
  EXPECT_EQ(here.Place(point), there.Place(point * 1024.0f));
  EXPECT_FLOAT_EQ(here.Place({0, 3, 0}).y - here.Place({0, -1, 0}).y, kBlendCells);
  // Within the range that BlendThreshold knows, whatever the offset.
  for (uint32_t node = 0; node < 1000; ++node) {
    const BlendSpace space(MeshIn({-1, -1, -1}, {1, 3, 1}), InstanceOf(node, 0, 0));
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(space.Place({-1, -1, -1})[axis], 0);
      EXPECT_LT(space.Place({1, 3, 1})[axis], kBlendCells + kBlendOffsets + 1);
    }
  }
  const BlendSpace point_mesh(MeshIn({5, 5, 5}, {5, 5, 5}), moved);
  EXPECT_LT(point_mesh.Place({5, 5, 5}).x, kBlendOffsets + 1) << "no extent, no cells";
}

// Two instances over each other hide 1 - (1 - a)(1 - b), whether they differ by node, mesh or place.
TEST(BlendTest, InstancesHaveHolesOfTheirOwn) {
  const Mesh mesh = MeshIn({0, 0, 0}, {1, 0, 1});
  const BlendSpace first(mesh, InstanceOf(3, 1, 0));
  for (const Instance& other : {InstanceOf(4, 1, 0), InstanceOf(3, 2, 0), InstanceOf(3, 1, 1)}) {
    const BlendSpace second(mesh, other);
    constexpr int kSide = 128;
    int both = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const glm::vec3 at((float(x) + 0.5f) / kSide, 0, (float(y) + 0.5f) / kSide);
        both += BlendThreshold(first.Place(at)) > 0.5f && BlendThreshold(second.Place(at)) > 0.5f;
      }
    }
    // A binomial's 3 sigma: 3 sqrt(3 / 16) / 128.
    EXPECT_NEAR(double(both) / (kSide * kSide), 0.25, 0.0102);
  }
}

TEST(RayMaskTest, OfBlendTheShareOfAlphaHides) {
  constexpr int kPlaces = 1 << 16;
  for (const float alpha : {0.0f, 0.25f, 0.75f, 1.0f}) {
    const RayMask mask(Blend(alpha));
    EXPECT_TRUE(mask.is_blend());
    int hidden = 0;
    for (const glm::vec3& place : RandomPlaces(kPlaces)) hidden += !mask.IsMaskedAway({0, 0}, alpha, place);
    // 4 sigma; none and all are exact.
    EXPECT_NEAR(hidden / double(kPlaces), alpha, 4 * std::sqrt(alpha * (1 - alpha) / kPlaces)) << alpha;
  }
}

}  // namespace
}  // namespace halfshade
