// Rising sort of short lists of 32-bit keys, in SIMD.
#pragma once

#include <cstddef>
#include <cstdint>

namespace halfshade::pdsm {

void SortKeys(uint32_t* keys, size_t count);

}  // namespace halfshade::pdsm
