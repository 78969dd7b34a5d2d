#include "renderer/scene_loader/image_header.h"

namespace halfshade {
namespace {

uint32_t Big(const std::string& bytes, size_t at, int count) {
  uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | uint8_t(bytes[at + size_t(i)]);
  return value;
}

ImageHeader ReadJpeg(const std::string& bytes) {
  for (size_t at = 2; at + 9 <= bytes.size();) {
    if (uint8_t(bytes[at]) != 0xff) return {};
    const uint8_t marker = uint8_t(bytes[at + 1]);
    if (marker == 0xff) {
      ++at;
      continue;
    }
    // Start of frame: C0 to CF but for the tables C4, C8 and CC.
    if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) {
      return {ImageFormat::kJpeg, Big(bytes, at + 7, 2), Big(bytes, at + 5, 2)};
    }
    at += 2 + Big(bytes, at + 2, 2);
  }
  return {};
}

}  // namespace

ImageHeader ReadImageHeader(const std::string& bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n") && bytes.size() >= 24) {
    return {ImageFormat::kPng, Big(bytes, 16, 4), Big(bytes, 20, 4)};
  }
  if (bytes.starts_with("\xff\xd8")) return ReadJpeg(bytes);
  return {};
}

}  // namespace halfshade
