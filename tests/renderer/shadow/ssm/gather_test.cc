// The gather against closed forms, on maps made by hand: no GL.
#include "renderer/shadow/ssm/gather.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "tests/support/closed_forms.h"

namespace halfshade {
namespace {

constexpr double kNear = 0.9;
constexpr int kSize = 64;  // patches a side

// Slopes -.8 .. .8 seen from the light's centre; in a square of [-.4, .4]^2 a plate at z = 1, around it what is at
// ground_z (0: nothing).
BinnedMap PlateMap(int texels_per_patch, int slabs, double ground_z = 0) {
  BinnedMap map;
  map.texels_per_patch = texels_per_patch;
  map.map_size = kSize * texels_per_patch;
  map.slope_per_texel = glm::dvec2(1.6 / map.map_size);
  map.first_center = glm::dvec2(-0.8) + 0.5 * map.slope_per_texel;
  map.z_near = kNear;
  map.depths.assign(size_t(map.map_size) * map.map_size + BinnedMap::kPadding, 0);
  for (int y = 1; y + 1 < map.map_size; ++y) {
    for (int x = 1; x + 1 < map.map_size; ++x) {
      const glm::dvec2 slope = glm::abs(map.first_center + map.slope_per_texel * glm::dvec2(x, y));
      const bool is_plate = std::max(slope.x, slope.y) < 0.4;
      map.depths[size_t(y) * map.map_size + x] = is_plate ? float(kNear) : ground_z > 0 ? float(kNear / ground_z) : 0;
    }
  }
  map.tables = *BuildDepthTables(map.depths.data(), kSize, texels_per_patch, slabs);
  return map;
}

// Receivers of the plane z = 2 that face the light; x, y along the light's edges.
struct Receivers {
  std::vector<glm::dvec2> places;
  std::unique_ptr<ReceiverTile> tile = std::make_unique<ReceiverTile>();
  explicit Receivers(const std::vector<glm::dvec2>& at, double z = 2) : places(at) {
    tile->count = int(at.size());
    tile->shares_plane = tile->sees_whole_light = true;
    tile->w_low = tile->w_high = 1 / z;
    tile->slope_low = tile->slope_high = at[0] / z;
    for (int i = 0; i < tile->count; ++i) {
      tile->index[i] = uint32_t(i);
      tile->u[i] = at[i].x / z;
      tile->v[i] = at[i].y / z;
      tile->w[i] = 1 / z;
      tile->normal_x[i] = tile->normal_y[i] = 0;
      tile->normal_z[i] = -1;
      tile->height[i] = float(z);
      tile->error[i] = 4e-6f;
      tile->slope_low = glm::min(tile->slope_low, at[i] / z);
      tile->slope_high = glm::max(tile->slope_high, at[i] / z);
    }
  }
  std::vector<float> Hidden(const BinnedMap& map, double half_edge) const {
    std::vector<float> hidden(places.size()), share(places.size());
    GatherTile({&map, 1}, glm::vec2(float(half_edge)), *tile, nullptr, hidden.data(), share.data());
    for (const float s : share) EXPECT_EQ(s, 1);
    return hidden;
  }
};

std::vector<glm::dvec2> Across() {
  std::vector<glm::dvec2> places;
  for (int i = 0; i < ReceiverTile::kMost; ++i) places.emplace_back(-0.1 + 0.025 * i, 0.7 + 0.013 * (i % 9));
  return places;
}

// The plate's edges lie on patches' edges: the trapezoid is exact, in tables and texel by texel alike.
TEST(GatherTest, APlateCastsItsTrapezoid) {
  for (const double half_edge : {0.1, 0.5}) {
    for (const int slabs : {1, 4, 16}) {
      for (const double ground_z : {0.0, 2.0, 2.5}) {
        const Receivers receivers(Across());
        const BinnedMap map = PlateMap(1, slabs, ground_z);
        const std::vector<float> hidden = receivers.Hidden(map, half_edge);
        // Floats; and where a slab holds the ground too, the plate's depth in it is rounded to 2^-13 of the slab.
        const double bound = ground_z > 0 ? 1e-4 : 2e-5;
        for (size_t i = 0; i < hidden.size(); ++i) {
          const glm::dvec3 at(receivers.places[i], 2);
          const double truth = 1 - VisibilityBehindPlate(glm::dvec2(half_edge), {0, 0, 1}, {0.4, 0.4}, at);
          EXPECT_NEAR(hidden[i], truth, bound)
              << half_edge << " slabs " << slabs << " ground " << ground_z << " at " << i;
        }
      }
    }
  }
}

TEST(GatherTest, NothingInReachIsExactlyLitAndACoveredWindowExactlyDark) {
  const BinnedMap map = PlateMap(2, 4);
  EXPECT_EQ(Receivers({{1.5, 0}, {0, -1.55}}).Hidden(map, 0.1), std::vector<float>({0, 0}));
  EXPECT_EQ(Receivers({{0, 0}, {0.3, -0.3}}).Hidden(map, 0.1), std::vector<float>({1, 1}));
  // Receivers nearer to the light than the plate, or on it.
  EXPECT_EQ(Receivers({{0, 0}, {0.2, 0.1}}, 0.95).Hidden(map, 0.1), std::vector<float>({0, 0}));
  EXPECT_EQ(Receivers({{0, 0}, {0.2, 0.1}}, 1).Hidden(map, 0.1), std::vector<float>({0, 0}));
}

// What is proven for a tile changes no bit of what a receiver alone gets.
TEST(GatherTest, ReceiversGetTheSameAloneAndTogether) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  BinnedMap map = PlateMap(2, 4, 2.4);
  for (int i = 0; i < map.map_size * map.map_size; ++i) {
    if (map.depths[i] > 0 && any(random) < 0.3) map.depths[i] = float(kNear / (1.7 + 0.6 * any(random)));
  }
  map.tables = *BuildDepthTables(map.depths.data(), kSize, 2, 4);
  for (int round = 0; round < 50; ++round) {
    const glm::dvec2 middle(any(random), any(random));
    std::vector<glm::dvec2> places;
    for (int i = 0; i < ReceiverTile::kMost; ++i) places.push_back(middle + 0.1 * glm::dvec2(any(random), any(random)));
    const double half_edge = 0.3 + 0.28 * any(random);
    const std::vector<float> together = Receivers(places).Hidden(map, half_edge);
    for (size_t i = 0; i < places.size(); ++i) {
      EXPECT_EQ(together[i], Receivers({places[i]}).Hidden(map, half_edge)[0]) << round << " " << i;
      EXPECT_GE(together[i], 0);
      EXPECT_LE(together[i], 1);
    }
  }
}

// The plane z = 2 is no occluder of itself, whatever slab it lies in; what stands on it is.
TEST(GatherTest, AReceiversOwnSurfaceDoesNotHideAndContactDoes) {
  BinnedMap map = PlateMap(2, 4, 2);
  EXPECT_EQ(Receivers({{1.3, 0.1}, {-1.2, 1.2}}).Hidden(map, 0.05), std::vector<float>({0, 0}));
  // A step of 2 mm on it, at u in [.5, .6]: its shadow is dark up to the foot.
  for (int y = 1; y + 1 < map.map_size; ++y) {
    for (int x = 1; x + 1 < map.map_size; ++x) {
      const double u = map.first_center.x + map.slope_per_texel.x * x;
      if (u > 0.5 && u < 0.6) map.depths[size_t(y) * map.map_size + x] = float(kNear / 1.998);
    }
  }
  map.tables = *BuildDepthTables(map.depths.data(), kSize, 2, 4);
  EXPECT_EQ(Receivers({{1.1, 0.2}}).Hidden(map, 0.05)[0], 1);
}

}  // namespace
}  // namespace halfshade
