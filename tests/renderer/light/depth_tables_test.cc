#include "renderer/light/depth_tables.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace halfshade {
namespace {

uint32_t BoxSum(const DepthTables& tables, int x0, int y0, int x1, int y1, int i) {
  return tables.At(x1, y1)[i] - tables.At(x0, y1)[i] - tables.At(x1, y0)[i] + tables.At(x0, y0)[i];
}

// A third empty, the rest between .25 and .75.
std::vector<float> RandomDepths(int side) {
  std::mt19937 random(side);
  std::uniform_real_distribution<float> any(0, 1);
  std::vector<float> depths(size_t(side) * side);
  for (float& depth : depths) depth = any(random) < 0.33f ? 0 : 0.25f + 0.5f * any(random);
  return depths;
}

TEST(DepthTablesTest, BoxesHoldTheAreaAndTheMeanDepthOfEverySlab) {
  for (const int texels : {1, 2, 4}) {
    for (const int slabs : {1, 3, 8, 16}) {
      constexpr int kSize = 13;
      const int side = kSize * texels;
      const std::vector<float> depths = RandomDepths(side);
      const DepthTables tables = *BuildDepthTables(depths.data(), kSize, texels, slabs);
      EXPECT_EQ(tables.SizeBytes(), DepthTables::SizeBytes(kSize, slabs));
      const int boxes[][4] = {{0, 0, kSize, kSize}, {2, 3, 9, 11}, {5, 5, 6, 6}, {0, 7, 13, 8}, {4, 4, 4, 9}};
      for (const auto& [x0, y0, x1, y1] : boxes) {
        std::vector<double> count(slabs), sum(slabs);
        for (int y = y0 * texels; y < y1 * texels; ++y) {
          for (int x = x0 * texels; x < x1 * texels; ++x) {
            const float depth = depths[size_t(y) * side + x];
            if (depth == 0) continue;
            const int slab = std::min(int(tables.PlaceOf(depth)), slabs - 1);
            count[slab] += 1;
            sum[slab] += depth;
          }
        }
        double nearer = 0;
        for (int slab = slabs - 1; slab >= 0; --slab) {
          nearer += count[slab];
          EXPECT_EQ(BoxSum(tables, x0, y0, x1, y1, slab),
                    uint32_t(nearer) * DepthTables::kFullPatch / uint32_t(texels * texels));
          if (count[slab] == 0) continue;
          const double area = count[slab] * DepthTables::kFullPatch / (texels * texels);
          const double place = BoxSum(tables, x0, y0, x1, y1, slabs + slab) / (DepthTables::kPlaces * area);
          // Places are rounded to a 16th of a texel's area: 16 of a patch in 16.
          EXPECT_NEAR(tables.SlabStart(slab) + place * tables.slab_depth, sum[slab] / count[slab],
                      tables.slab_depth / 512);
        }
      }
    }
  }
}

TEST(DepthTablesTest, AFlatMapIsOneSlabDeepAndAnEmptyOneShowsNothing) {
  const std::vector<float> flat(64, 0.5f);
  const DepthTables tables = *BuildDepthTables(flat.data(), 8, 1, 4);
  EXPECT_EQ(tables.nearest_depth, 0.5f);
  EXPECT_EQ(tables.first_depth, 0.5f);
  EXPECT_GT(tables.slab_depth, 0);
  EXPECT_LT(tables.slab_depth, 1e-6f);
  EXPECT_EQ(BoxSum(tables, 1, 1, 8, 3, 0), 14 * DepthTables::kFullPatch);
  EXPECT_EQ(BoxSum(tables, 1, 1, 8, 3, 1), 0u);

  const std::vector<float> empty(64, 0.0f);
  const DepthTables nothing = *BuildDepthTables(empty.data(), 8, 1, 4);
  EXPECT_TRUE(nothing.IsEmpty());
  EXPECT_EQ(BoxSum(nothing, 0, 0, 8, 8, 0), 0u);
}

// What a table of floats loses: one texel in a million.
TEST(DepthTablesTest, TheLargestTableStillTellsOneTexelFromAnother) {
  constexpr int kSize = DepthTables::kMaxSize;
  std::vector<float> depths(size_t(kSize) * kSize, 1.0f);
  depths[size_t(kSize - 2) * kSize + kSize - 2] = 0;
  depths[0] = 0.5f;
  const DepthTables tables = *BuildDepthTables(depths.data(), kSize, 1, 2);
  EXPECT_EQ(BoxSum(tables, kSize - 3, kSize - 3, kSize, kSize, 0), 8 * DepthTables::kFullPatch);
  EXPECT_EQ(BoxSum(tables, 0, 0, kSize, kSize, 0), (uint32_t(kSize) * kSize - 1) * DepthTables::kFullPatch);
  EXPECT_EQ(BoxSum(tables, 0, 0, kSize, kSize, 1), (uint32_t(kSize) * kSize - 2) * DepthTables::kFullPatch);
  // All at the nearest end of the last slab: its largest moment.
  EXPECT_EQ(BoxSum(tables, 0, 0, kSize, kSize, 3),
            (uint32_t(kSize) * kSize - 2) * DepthTables::kFullPatch * uint32_t(DepthTables::kPlaces));
}

}  // namespace
}  // namespace halfshade
