// A FlatScene as bytes: what the scene loader hands over, and what the store keeps so that nothing is parsed twice.
//
// Magic, kFlatFormVersion, every array of the scene as its count and its elements, a 64-bit XXH3 of all that. Little
// endian, unaligned. The checksum finds accidents; CheckFlatScene finds forgeries, so that bytes from anywhere may be
// read. Thread-safe: no state.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "renderer/scene/flat_scene.h"

namespace halfshade {

// To be raised with every change of FlatScene, of its form, or of what the loader makes of a file: older bytes are then
// another version's, and whoever kept them loads the file again.
inline constexpr uint32_t kFlatFormVersion = 1;

// Takes the form in pieces; false ends the writing.
using ByteSink = std::function<bool(const void* bytes, size_t size)>;

// Beside the scene it takes 64 KiB. False where the sink said so.
bool WriteFlatScene(const FlatScene& scene, const ByteSink& sink);
std::string FlatSceneBytes(const FlatScene& scene);

// DATA_LOSS with the reason: other bytes, another version, a wrong checksum, a count beyond the end, bytes left over,
// or a scene that is not valid (CheckFlatScene). What is allocated is bounded by a small multiple of the bytes.
absl::StatusOr<FlatScene> ReadFlatScene(std::string_view bytes);

}  // namespace halfshade
