#include "renderer/scene/ray_mask.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace halfshade {
namespace {

constexpr int kWidth = 5, kHeight = 3;

std::vector<uint8_t> RandomAlphas() {
  std::mt19937 random(5);
  std::vector<uint8_t> rgba(4 * kWidth * kHeight);
  for (uint8_t& value : rgba) value = uint8_t(random());
  return rgba;
}

// As OpenGL 4.6, 8.14.2 has it.
int WrappedTexel(int texel, int size, Wrap wrap) {
  if (wrap == Wrap::kClampToEdge) return std::min(std::max(texel, 0), size - 1);
  const auto modulo = [](int a, int b) { return ((a % b) + b) % b; };
  if (wrap == Wrap::kRepeat) return modulo(texel, size);
  const int mirrored = modulo(texel, 2 * size) - size;
  return (size - 1) - (mirrored >= 0 ? mirrored : -(1 + mirrored));
}

double AlphaOf(const std::vector<uint8_t>& rgba, const Texture& texture, double s, double t) {
  const auto texel = [&](int x, int y) {
    return rgba[4 * (WrappedTexel(y, kHeight, texture.wrap_t) * kWidth + WrappedTexel(x, kWidth, texture.wrap_s)) + 3] /
           255.0;
  };
  const double x = s * kWidth, y = t * kHeight;
  if (texture.magnifies_to_nearest) return texel(int(std::floor(x)), int(std::floor(y)));
  const int left = int(std::floor(x - 0.5)), top = int(std::floor(y - 0.5));
  const double u = x - 0.5 - left, v = y - 0.5 - top;
  return (texel(left, top) * (1 - u) + texel(left + 1, top) * u) * (1 - v) +
         (texel(left, top + 1) * (1 - u) + texel(left + 1, top + 1) * u) * v;
}

TEST(RayMaskTest, TexelsAreWrappedAndFilteredAsOpenGlHasIt) {
  const std::vector<uint8_t> rgba = RandomAlphas();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-7, 7);
  for (const Wrap wrap : {Wrap::kRepeat, Wrap::kMirroredRepeat, Wrap::kClampToEdge}) {
    for (const bool is_nearest : {false, true}) {
      Texture texture;
      texture.wrap_s = texture.wrap_t = wrap;
      texture.magnifies_to_nearest = is_nearest;
      const RayMask mask(Material(), texture, kWidth, kHeight, rgba);
      int asked = 0, masked = 0;
      for (int i = 0; i < 20000; ++i) {
        const glm::vec2 at(place(random), place(random));
        const double alpha = AlphaOf(rgba, texture, at.x, at.y);
        // A seven-fold period is off by 7 ulps: of a texel's edge, and of the cutoff, a little is left out.
        if (std::abs(alpha - 0.5) < 1e-4) continue;
        const double edge_x = std::abs(at.x * kWidth - std::round(at.x * kWidth));
        const double edge_y = std::abs(at.y * kHeight - std::round(at.y * kHeight));
        if (is_nearest && std::min(edge_x, edge_y) < 1e-4) continue;
        ++asked;
        masked += alpha < 0.5;
        EXPECT_EQ(mask.IsMaskedAway(at, 1), alpha < 0.5) << at.x << " " << at.y;
      }
      EXPECT_GT(asked, 19000);
      EXPECT_GT(masked, 2000);
      EXPECT_LT(masked, 18000);
    }
  }
}

TEST(RayMaskTest, PlacesBeyondFloatsReachAreSomeTexel) {
  const RayMask mask(Material(), {}, kWidth, kHeight, std::vector<uint8_t>(4 * kWidth * kHeight, 255));
  for (const float far : {1e9f, -1e9f, 3e38f, -3e38f, -1e-9f}) EXPECT_FALSE(mask.IsMaskedAway({far, far}, 1));
}

TEST(RayMaskTest, WithoutATextureTheVertexAlphaIsCompared) {
  const RayMask mask{Material()};
  EXPECT_FALSE(mask.IsMaskedAway({0, 0}, 0.5f));
  EXPECT_TRUE(mask.IsMaskedAway({0, 0}, 0.49f));
}

}  // namespace
}  // namespace halfshade
