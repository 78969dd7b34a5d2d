// A validated glTF to the flat scene.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/scene/flat_scene.h"
#include "renderer/scene_loader/accessor_reader.h"
#include "renderer/scene_loader/gltf_json.h"
#include "renderer/scene_loader/scene_loader.h"

namespace halfshade {

// Requires what ValidateGltf and CheckSparseIndices have passed; takes the images and warnings of `gltf`. Checked here:
// index values, finite positions, world coordinates, numbers of triangles, instances and bytes.
absl::StatusOr<FlatScene> BuildFlatScene(const GltfData& data, const SceneLoadLimits& limits, Gltf* gltf);

}  // namespace halfshade
