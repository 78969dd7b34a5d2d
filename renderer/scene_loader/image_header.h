// What an encoded image says of itself, read from its first bytes alone.
#pragma once

#include <cstdint>
#include <string>

namespace halfshade {

enum class ImageFormat { kUnknown, kPng, kJpeg };

struct ImageHeader {
  ImageFormat format = ImageFormat::kUnknown;
  uint32_t width = 0;
  uint32_t height = 0;
};

// kUnknown for anything but a PNG or JPEG whose header holds a size.
ImageHeader ReadImageHeader(const std::string& bytes);

}  // namespace halfshade
