// Images to files' bytes. Runs on the CPU pool, not on a GL thread; thread-safe. The same image gives the same bytes.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

#include "renderer/renderer.h"

namespace halfshade {

enum class Encoding : uint8_t { kPng, kRawF32 };

struct EncodedImage2D {
  std::string bytes;
  int channels = 0;  // as encoded: a FRAME's PNG has no alpha
  std::string
      pixel_sha256;  // of the pixels as given to the encoder: sample type, little-endian, [row][column][channel]
  double encode_ms = 0;
  double digest_ms = 0;
};

// FRAME as PNG: 8 bit sRGB without alpha. VISIBILITY as PNG: 16 bit, linear, 1 to 4 channels. RAW_F32: every channel as
// it is. INTERNAL for a NaN in the image or an encoder that fails.
absl::StatusOr<EncodedImage2D> Encode(const RenderedImage& rendered, Encoding encoding);

// What Encode will give the encoder, in bytes: known before drawing. `lights`: channels of VISIBILITY.
uint64_t UncompressedBytes(OutputKind kind, Encoding encoding, int width, int height, int lights);

}  // namespace halfshade
