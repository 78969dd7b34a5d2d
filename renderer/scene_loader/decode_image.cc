#include "renderer/scene_loader/decode_image.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>

namespace {

// A PNG may inflate to any multiple of what its header tells: no block of memory may be larger than this.
thread_local size_t max_block_bytes = 0;

void* BoundedRealloc(void* block, size_t bytes) {
  return bytes <= max_block_bytes ? std::realloc(block, bytes) : nullptr;
}

}  // namespace

#define STBI_MALLOC(bytes) BoundedRealloc(nullptr, bytes)
#define STBI_REALLOC(block, bytes) BoundedRealloc(block, bytes)
#define STBI_FREE(block) std::free(block)
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#include <stb/stb_image.h>

namespace halfshade {
namespace {

// The decoder's own state, and what it reads a file of `file_bytes` into.
constexpr size_t kDecoderBytes = 1 << 20;

const stbi_uc* Bytes(std::string_view bytes) { return reinterpret_cast<const stbi_uc*>(bytes.data()); }

}  // namespace

ImageHeader ReadImageHeader(std::string_view bytes) {
  ImageHeader header;
  if (bytes.size() > size_t(std::numeric_limits<int>::max())) return header;
  const bool is_png = bytes.starts_with("\x89PNG\r\n\x1a\n");
  int width = 0, height = 0, channels = 0;
  max_block_bytes = kDecoderBytes;
  if (stbi_info_from_memory(Bytes(bytes), int(bytes.size()), &width, &height, &channels) == 0) return header;
  header.format = is_png ? ImageFormat::kPng : ImageFormat::kJpeg;
  header.width = uint32_t(width);
  header.height = uint32_t(height);
  return header;
}

absl::StatusOr<Rgba8Image> DecodeImage(const EncodedImage& image, uint64_t max_pixels) {
  const ImageHeader header = ReadImageHeader(image.bytes);
  if (header.format == ImageFormat::kUnknown) {
    return absl::InvalidArgumentError(image.name + ": neither a PNG nor a JPEG");
  }
  const uint64_t pixels = uint64_t(header.width) * header.height;
  if (!header.IsWithin(max_pixels)) {
    return absl::InvalidArgumentError(image.name + ": " + std::to_string(pixels) + " pixels; at most " +
                                      std::to_string(max_pixels) + ", and " + std::to_string(ImageHeader::kMaxEdge) +
                                      " along an edge");
  }
  // Four channels of 16 bits; a JPEG's planes are padded to blocks of 32 pixels. A PNG's data are gathered in steps of
  // powers of two.
  const size_t padded = (size_t(header.width) + 32) * (size_t(header.height) + 32) * 8;
  max_block_bytes = kDecoderBytes + std::max(padded, 2 * image.bytes.size());
  int width = 0, height = 0, channels = 0;
  const std::unique_ptr<stbi_uc, void (*)(void*)> texels(
      stbi_load_from_memory(Bytes(image.bytes), int(image.bytes.size()), &width, &height, &channels, 4),
      stbi_image_free);
  if (texels == nullptr) {
    return absl::InvalidArgumentError(image.name + ": does not decode: " + stbi_failure_reason());
  }
  Rgba8Image result;
  result.width = width;
  result.height = height;
  result.texels.assign(texels.get(), texels.get() + size_t(width) * size_t(height) * 4);
  return result;
}

}  // namespace halfshade
