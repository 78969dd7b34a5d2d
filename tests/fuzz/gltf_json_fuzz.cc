// The JSON of a GLB whose chunk of bytes is large enough for most of what it may say: the validator, and what stands
// behind it.
#include <cstdint>
#include <cstring>

#include "renderer/scene_loader/scene_loader.h"
#include "tests/fuzz/flat_scene_use.h"

namespace {

std::string Chunk(const char* type, std::string bytes, char pad) {
  bytes.resize((bytes.size() + 3) / 4 * 4, pad);
  const auto size = uint32_t(bytes.size());
  std::string chunk(reinterpret_cast<const char*>(&size), sizeof(size));
  return chunk.append(type, 4) + bytes;
}

// Floats from 0 to 1 that differ, the first of them also small integers.
std::string Numbers() {
  std::string bytes;
  for (int i = 0; i < 4096; ++i) {
    const float number = i < 16 ? 0 : float(i % 97) / 97;
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
  }
  for (int i = 0; i < 64; ++i) bytes[size_t(i)] = char(i % 4 == 0 ? i / 4 % 3 : 0);
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace halfshade;
  static const std::string& bin = *new std::string(Chunk("BIN\0", Numbers(), '\0'));
  const std::string chunks = Chunk("JSON", std::string(reinterpret_cast<const char*>(data), size), ' ') + bin;
  const uint32_t header[] = {0x46546C67, 2, uint32_t(12 + chunks.size())};
  SceneLoadLimits limits;
  limits.max_scene_bytes = 16 << 20;
  limits.max_triangles = 20000;
  const auto scene = LoadGltf(std::string(reinterpret_cast<const char*>(header), sizeof(header)) + chunks, {}, limits);
  if (scene.ok()) {
    UseLoadedScene(*scene);
  } else {
    Require(absl::IsInvalidArgument(scene.status()));
  }
  return 0;
}
