// Reads strangers' PNG and JPEG, by stb_image: their headers when a scene is loaded, their texels when they are needed.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string_view>

#include "renderer/renderer.h"

namespace halfshade {

enum class ImageFormat : uint8_t { kUnknown, kPng, kJpeg };

struct ImageHeader {
  ImageFormat format = ImageFormat::kUnknown;
  uint32_t width = 0;
  uint32_t height = 0;

  // The longest edge of a texture that every GL 4.5 takes.
  static constexpr uint32_t kMaxEdge = 16384;
  bool IsWithin(uint64_t max_pixels) const {
    return width <= kMaxEdge && height <= kMaxEdge && uint64_t(width) * height <= max_pixels;
  }
};

// kUnknown for anything but a PNG or JPEG whose header the decoder takes.
ImageHeader ReadImageHeader(std::string_view bytes);

// INVALID_ARGUMENT naming the image for bytes that do not decode, and for more than max_pixels or kMaxEdge (told from
// the header, before anything is decoded). Memory is bounded by the pixels, whatever the bytes inflate to. Thread-safe.
absl::StatusOr<Rgba8Image> DecodeImage(const EncodedImage& image, uint64_t max_pixels);

}  // namespace halfshade
