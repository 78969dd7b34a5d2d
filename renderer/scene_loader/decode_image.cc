#include "renderer/scene_loader/decode_image.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>

namespace {

// A PNG may inflate to any multiple of what its header tells: no block of memory may be larger than this.
thread_local size_t max_block_bytes = 0;

// Zeros: Debian's stb_image (2.27) decodes with tables that a JPEG never gave, and returns blocks that it never had.
void* BoundedAlloc(size_t bytes) { return bytes <= max_block_bytes ? std::calloc(1, bytes) : nullptr; }

void* BoundedRealloc(void* block, size_t bytes) {
  return bytes <= max_block_bytes ? std::realloc(block, bytes) : nullptr;
}

}  // namespace

#define STBI_MALLOC(bytes) BoundedAlloc(bytes)
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

constexpr uint32_t kStartOfScan = 0xda;

uint32_t At(std::string_view bytes, size_t at) { return at < bytes.size() ? uint8_t(bytes[at]) : 0; }

// Whether the Huffman tables of the DHT segment whose length stands at `at` have at most 256 codes each: Debian's
// stb_image (2.27) writes as many as a table claims, up to 4080, into an array of 257.
bool HasSoundTables(std::string_view bytes, size_t at) {
  int64_t left = int64_t(At(bytes, at) << 8 | At(bytes, at + 1)) - 2;
  for (at += 2; left > 0;) {
    uint32_t codes = 0;
    for (size_t i = 1; i <= 16; ++i) codes += At(bytes, at + i);
    if (codes > 256) return false;
    at += 17 + codes;
    left -= 17 + int64_t(codes);
  }
  return true;
}

// What a JPEG gives, wherever it stands.
struct JpegParts {
  bool has_sound_tables = true;  // of Huffman codes
  bool has_huffman = false, has_quantization = false, has_scan = false;

  // The parts of the marker at `at`.
  void Add(std::string_view bytes, size_t at) {
    constexpr uint32_t kHuffman = 0xc4, kQuantization = 0xdb;
    const uint32_t marker = At(bytes, at + 1);
    has_huffman |= marker == kHuffman;
    has_quantization |= marker == kQuantization;
    has_scan |= marker == kStartOfScan;
    if (marker == kHuffman) has_sound_tables &= HasSoundTables(bytes, at + 2);
  }
};

// As stb_image would come upon them: segment by segment as long as these follow each other; from the first scan on, or
// where they do not, behind any marker.
JpegParts FindJpegParts(std::string_view bytes) {
  JpegParts parts;
  size_t at = 2;
  if (At(bytes, 0) != 0xff || At(bytes, 1) != 0xd8) at = 0;
  while (at > 0 && At(bytes, at) == 0xff && At(bytes, at + 1) >= 0xc0 && At(bytes, at + 1) != kStartOfScan &&
         At(bytes, at + 1) != 0xff) {
    parts.Add(bytes, at);
    at += 2 + std::max(2u, At(bytes, at + 2) << 8 | At(bytes, at + 3));
  }
  for (; at + 1 < bytes.size(); ++at) {
    if (At(bytes, at) == 0xff) parts.Add(bytes, at);
  }
  return parts;
}

// What keeps a JPEG from being decoded that stb_image makes grey; null: nothing.
const char* MissingOf(const JpegParts& parts) {
  if (!parts.has_huffman) return "a JPEG without Huffman tables";  // as a frame of Motion JPEG
  if (!parts.has_quantization) return "a JPEG without quantization tables";
  return parts.has_scan ? nullptr : "a JPEG without a scan";
}

const stbi_uc* Bytes(std::string_view bytes) { return reinterpret_cast<const stbi_uc*>(bytes.data()); }

}  // namespace

ImageHeader ReadImageHeader(std::string_view bytes) {
  ImageHeader header;
  if (bytes.size() > size_t(std::numeric_limits<int>::max())) return header;
  const bool is_png = bytes.starts_with("\x89PNG\r\n\x1a\n");
  if (!is_png && !FindJpegParts(bytes).has_sound_tables) return header;
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
  if (header.format == ImageFormat::kJpeg) {
    if (const char* missing = MissingOf(FindJpegParts(image.bytes))) {
      return absl::InvalidArgumentError(image.name + ": does not decode: " + missing);
    }
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
