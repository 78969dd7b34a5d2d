// Decodes strangers' PNG and JPEG by stb_image.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>

#include "renderer/renderer.h"

namespace halfshade {

// INVALID_ARGUMENT naming the image for bytes that do not decode, or for more than max_pixels (told from the header, before
// anything is decoded). Thread-safe.
absl::StatusOr<Rgba8Image> DecodeImage(const EncodedImage& image, uint64_t max_pixels);

}  // namespace halfshade
