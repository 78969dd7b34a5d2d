// The flat form, sealed as a forger would: whatever is let in can be posed, animated and bent.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstdint>

#include "tests/fuzz/flat_scene_use.h"
#include "tests/renderer/scene/every_array_scene.h"

namespace {

constexpr size_t kHeaderBytes = 12, kChecksumBytes = 8;

}  // namespace

// The header and checksum of the input, if it has them, are replaced.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace halfshade;
  static const std::string& good = *new std::string(FlatSceneBytes(MakeEveryArrayScene()));
  std::string bytes(reinterpret_cast<const char*>(data), size);
  if (bytes.size() < kHeaderBytes + kChecksumBytes) bytes = good;
  bytes.replace(0, kHeaderBytes, good, 0, kHeaderBytes);
  bytes.resize(bytes.size() - kChecksumBytes);
  const XXH64_hash_t checksum = XXH3_64bits(bytes.data(), bytes.size());
  bytes.append(reinterpret_cast<const char*>(&checksum), sizeof(checksum));
  const auto scene = ReadFlatScene(bytes);
  if (scene.ok()) {
    Require(FlatSceneBytes(*scene) == bytes);  // one form for each scene
    UseScene(*scene);
  } else {
    Require(absl::IsDataLoss(scene.status()));
  }
  return 0;
}
