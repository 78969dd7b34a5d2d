#include "renderer/image/srgb.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halfshade {
namespace {

TEST(SrgbTest, RoundTrips) {
  for (float x = 0; x <= 1; x += 1.0f / 512) EXPECT_NEAR(SrgbToLinear(LinearToSrgb(x)), x, 1e-6);
}

TEST(SrgbTest, CodesAreTheNearest) {
  for (float x = -0.1f; x <= 1.1f; x += 1.0f / 4096) {
    const float exact = LinearToSrgb(x) * 255;
    EXPECT_LE(std::abs(float(LinearToSrgb8(x)) - exact), 0.5f + 1e-3f) << x;
  }
  EXPECT_EQ(LinearToSrgb8(0), 0);
  EXPECT_EQ(LinearToSrgb8(1), 255);
  EXPECT_EQ(LinearToSrgb8(NAN), 0);
}

}  // namespace
}  // namespace halfshade
