// A checked tinygltf model to the flat scene.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "renderer/scene/flat_scene.h"
#include "renderer/scene_loader/scene_loader.h"

namespace tinygltf {
class Model;
}

namespace halfshade {

// Requires a model of JSON that ValidateGltf has passed. What only the data tell is checked here: index values, finite
// positions, triangles and bytes under the limits.
absl::StatusOr<FlatScene> BuildFlatScene(const tinygltf::Model& model, std::vector<std::string> images,
                                         std::vector<std::string> warnings, const SceneLoadLimits& limits);

}  // namespace halfshade
