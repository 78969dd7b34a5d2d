#include "renderer/math/sampling.h"

#include <array>

namespace halfshade {
namespace {

uint32_t ReverseBits(uint32_t x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  return (x >> 16) | (x << 16);
}

// A permutation in which each bit depends only on lower bits: on reversed bits, a nested uniform scramble.
uint32_t NestedHash(uint32_t x, uint32_t seed) {
  x += seed;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return x;
}

uint32_t Scramble(uint32_t x, uint32_t seed) { return ReverseBits(NestedHash(ReverseBits(x), seed)); }

// A mixing of seed and dimension (murmur3's finaliser).
uint32_t Mix(uint32_t x) {
  x ^= x >> 16;
  x *= 0x85ebca6bu;
  x ^= x >> 13;
  x *= 0xc2b2ae35u;
  return x ^ (x >> 16);
}

// Direction numbers of Sobol's second dimension: column i is column i-1 folded by the polynomial x + 1.
constexpr std::array<uint32_t, 32> SecondDimension() {
  std::array<uint32_t, 32> v{};
  v[0] = 0x80000000u;
  for (int i = 1; i < 32; ++i) v[i] = v[i - 1] ^ (v[i - 1] >> 1);
  return v;
}

}  // namespace

glm::dvec2 OwenSobol2(uint32_t index, uint32_t seed) {
  static constexpr std::array<uint32_t, 32> kSecond = SecondDimension();
  const uint32_t x = ReverseBits(index);
  uint32_t y = 0;
  for (int bit = 0; bit < 32; ++bit) {
    if ((index >> bit) & 1) y ^= kSecond[bit];
  }
  constexpr double kUnit = 1.0 / 4294967296.0;
  return {Scramble(x, Mix(2 * seed + 1)) * kUnit, Scramble(y, Mix(2 * seed + 2)) * kUnit};
}

}  // namespace halfshade
