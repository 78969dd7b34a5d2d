// glTF's semantics, checked on the JSON before tinygltf sees it: every index, range and number that the scene is built
// from. What only the bytes of a buffer tell is check_data.h's.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/scene_loader/container.h"
#include "renderer/scene_loader/gltf_json.h"
#include "renderer/scene_loader/scene_loader.h"

namespace halfshade {

// Elements of all the arrays that become arrays of ours; instances too. A file of this many would be larger than any
// that a person made, and each costs some hundred bytes, whatever the JSON spends on it.
inline constexpr size_t kMaxElements = 1 << 20;

// Buffers and images of the result point into `container` and `files`. INVALID_ARGUMENT, the message starting with the
// JSON pointer of the fault (or with "JSON:").
absl::StatusOr<Gltf> ValidateGltf(const GltfContainer& container, const FileMap& files, const SceneLoadLimits& limits);

}  // namespace halfshade
