// SIMD of the slices (slice_builder.h).
#pragma once

#include <cstddef>
#include <cstdint>

namespace halfshade::pdsm {

// counts[i] += values[i] > level, for i below `count`. Reads and writes up to kCountPadding bytes beyond.
inline constexpr size_t kCountPadding = 64;
void CountAbove(const uint8_t* values, uint8_t level, size_t count, uint8_t* counts);

}  // namespace halfshade::pdsm
