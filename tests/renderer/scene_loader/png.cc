#include "tests/renderer/scene_loader/png.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>

namespace halfshade {
namespace {

std::string Big(uint32_t value) {
  return {char(value >> 24), char(value >> 16 & 0xff), char(value >> 8 & 0xff), char(value & 0xff)};
}

std::string Chunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  const uLong crc = crc32(0, reinterpret_cast<const Bytef*>(body.data()), uInt(body.size()));
  return Big(uint32_t(data.size())) + body + Big(uint32_t(crc));
}

std::string Little(size_t value) {
  const uint32_t word = uint32_t(value);
  std::string bytes(4, '\0');
  std::memcpy(bytes.data(), &word, 4);
  return bytes;
}

}  // namespace

std::string MakePng(uint32_t width, uint32_t height, size_t inflated_bytes) {
  const std::string rows(std::max(size_t(4 * width + 1) * height, inflated_bytes), '\0');
  uLongf size = compressBound(uLong(rows.size()));
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
           uLong(rows.size()));
  packed.resize(size);
  const std::string format = {8, 6, 0, 0, 0};  // bits, RGBA, deflate, filters, not interlaced
  return "\x89PNG\r\n\x1a\n" + Chunk("IHDR", Big(width) + Big(height) + format) + Chunk("IDAT", packed) +
         Chunk("IEND", "");
}

std::string MakeGlb(std::string json, std::string bin) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  bin.resize((bin.size() + 3) / 4 * 4, '\0');
  return "glTF" + Little(2) + Little(28 + json.size() + bin.size()) + Little(json.size()) + "JSON" + json +
         Little(bin.size()) + std::string("BIN\0", 4) + bin;
}

}  // namespace halfshade
