// glTF's semantics, checked on the JSON before tinygltf sees it: every index, range and number that the scene is built from.
#pragma once

#include <absl/status/statusor.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "renderer/scene_loader/container.h"
#include "renderer/scene_loader/scene_loader.h"

namespace halfshade {

struct ValidGltf {
  nlohmann::json json;
  std::vector<std::string> buffers;   // bytes of each buffer, at least its byteLength
  std::vector<std::string> images;    // encoded bytes of each image
  std::vector<std::string> warnings;  // start with a JSON pointer
};

// INVALID_ARGUMENT, the message starting with the JSON pointer of the fault.
absl::StatusOr<ValidGltf> ValidateGltf(const GltfContainer& container, const FileMap& files,
                                       const SceneLoadLimits& limits);

// Bytes of one component: 1, 2 or 4; 0 for an unknown componentType.
int ComponentBytes(int64_t component_type);
// Components of an accessor type; 0 for an unknown one.
int TypeComponents(const std::string& type);

}  // namespace halfshade
