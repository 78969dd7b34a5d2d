// Containers for the loader's tests: PNGs of one colour, GLBs of given chunks.
#pragma once

#include <cstdint>
#include <string>

namespace halfshade {

// 8-bit RGBA, all texels 0, but for `inflated_bytes` of zeros in place of the texels where that is more.
std::string MakePng(uint32_t width, uint32_t height, size_t inflated_bytes = 0);

// A GLB of a JSON chunk and a BIN chunk, padded.
std::string MakeGlb(std::string json, std::string bin);

}  // namespace halfshade
