#include "renderer/image/srgb.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace halfshade {

float LinearToSrgb(float linear) {
  if (!(linear > 0)) return 0;
  if (linear >= 1) return 1;
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float SrgbToLinear(float encoded) {
  if (!(encoded > 0)) return 0;
  if (encoded >= 1) return 1;
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

uint8_t LinearToSrgb8(float linear) {
  // The linear value at which each code begins: a search of eight steps instead of a power for each of a frame's
  // values.
  static const std::array<float, 256> kBegins = [] {
    std::array<float, 256> begins{};
    for (int code = 1; code < 256; ++code) begins[code] = SrgbToLinear((float(code) - 0.5f) / 255);
    return begins;
  }();
  if (!(linear > 0)) return 0;
  return uint8_t(std::upper_bound(kBegins.begin() + 1, kBegins.end(), linear) - kBegins.begin() - 1);
}

}  // namespace halfshade
