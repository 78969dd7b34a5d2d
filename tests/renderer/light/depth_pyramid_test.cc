#include "renderer/light/depth_pyramid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "renderer/light/tiles.h"

namespace halfshade {
namespace {

TEST(DepthPyramidTest, EverySquareHoldsTheRangeOfItsTexels) {
  std::mt19937 random(3);
  for (const int size : {1, 4, 5, 16, 33, 100}) {
    std::vector<float> depths(size_t(size) * size);
    for (float& depth : depths) depth = std::uniform_real_distribution<float>(0, 1)(random);
    const DepthPyramid pyramid = BuildDepthPyramid(depths, size);
    EXPECT_EQ(pyramid.levels.back().side, 1);
    for (size_t level = 0; level < pyramid.levels.size(); ++level) {
      const int texels = DepthPyramid::kBaseTexels << level;
      const int side = pyramid.levels[level].side;
      EXPECT_EQ(side, (size + texels - 1) / texels) << size << " level " << level;
      for (int i = 0; i < side * side; ++i) {
        float low = 2, high = -1;
        for (int y = i / side * texels; y < std::min(size, (i / side + 1) * texels); ++y) {
          for (int x = i % side * texels; x < std::min(size, (i % side + 1) * texels); ++x) {
            low = std::min(low, depths[size_t(y) * size + x]);
            high = std::max(high, depths[size_t(y) * size + x]);
          }
        }
        EXPECT_EQ(pyramid.ranges[pyramid.levels[level].first + i], glm::vec2(low, high)) << size << " " << level;
      }
    }
  }
}

TEST(ListTilesTest, ATileIsListedForOnePixelAndAllAreWithoutAList) {
  std::vector<bool> is_wanted(40 * 20);
  EXPECT_TRUE(ListTiles(40, 20, is_wanted).empty());
  is_wanted[19 * 40 + 39] = true;
  is_wanted[15 * 40 + 16] = true;
  EXPECT_EQ(ListTiles(40, 20, is_wanted), TileList({{1, 0}, {2, 1}}));
  EXPECT_EQ(ListTiles(40, 20, {}).size(), 6u);
}

}  // namespace
}  // namespace halfshade
