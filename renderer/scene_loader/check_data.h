// What only the bytes of buffers tell: checked after validate_gltf, on the parsed model.
#pragma once

#include <absl/status/status.h>

#include "renderer/scene_loader/accessor_reader.h"

namespace halfshade {

// All return INVALID_ARGUMENT with the JSON pointer of the fault.

// Sparse indices increase and stay below the accessor's count. AccessorReader relies on it.
absl::Status CheckSparseIndices(const GltfData& data);
// Accessors of floats, used or not, hold neither infinities nor NaNs.
absl::Status CheckFloats(const GltfData& data);
// Joint numbers of skinned meshes are below the count of their skins' joints.
absl::Status CheckJoints(const GltfData& data);

}  // namespace halfshade
