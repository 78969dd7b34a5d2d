// What moves and multiplies meshes: skins, animations, instances of EXT_mesh_gpu_instancing; and what shines.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/scene/flat_scene.h"
#include "renderer/scene_loader/accessor_reader.h"
#include "renderer/scene_loader/gltf_json.h"
#include "renderer/scene_loader/scene_loader.h"

namespace halfshade {

void BuildSkins(const GltfData& data, FlatScene* scene);

// Appends the places that a node's extensions give it. INVALID_ARGUMENT for one that is not finite.
absl::Status BuildPlaces(const GltfData& data, const Place& extensions, Node* node, FlatScene* scene);

// Of a scene whose nodes stand already. A channel that cannot be played (times that decrease, too few values, a node
// with a matrix, what the node has not) is left out with a warning. INVALID_ARGUMENT where keys take more than the
// limit.
absl::Status BuildAnimations(const GltfData& data, const SceneLoadLimits& limits, Gltf* gltf, FlatScene* scene);

// Lights of KHR_lights_punctual and rectangles of two triangles that emit, as area lights that a request may have: each
// a warning that says so in a request's JSON. A scene lights nothing by itself.
void SuggestLights(const Gltf& gltf, const FlatScene& scene, Warnings* warnings);

}  // namespace halfshade
