// The sRGB transfer function (IEC 61966-2-1), exact and piecewise.
#pragma once

#include <cstdint>

namespace halfshade {

// Linear [0,1] to encoded [0,1]; clamped.
float LinearToSrgb(float linear);
// Encoded [0,1] to linear [0,1].
float SrgbToLinear(float encoded);
// Linear to the nearest of 256 codes. Monotonic.
uint8_t LinearToSrgb8(float linear);

}  // namespace halfshade
