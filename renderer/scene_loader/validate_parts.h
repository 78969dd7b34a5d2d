// The parts of validate_gltf, in the order in which they run: each trusts what the parts before it have checked.
#pragma once

#include <absl/status/status.h>

#include "renderer/scene_loader/container.h"
#include "renderer/scene_loader/gltf_json.h"
#include "renderer/scene_loader/scene_loader.h"

namespace halfshade {

// Buffers' lengths, buffer views, accessors, samplers, textures.
absl::Status ValidateData(const SceneLoadLimits& limits, Gltf* gltf);
// Materials, meshes.
absl::Status ValidateMeshes(Gltf* gltf);
// Cameras, nodes, scenes, skins, animations.
absl::Status ValidateNodes(Gltf* gltf);
// Finds the bytes of buffers and images: in data URIs, in the file map, in the BIN chunk. Nowhere else.
absl::Status ResolveBytes(const GltfContainer& container, const FileMap& files, Gltf* gltf);

// What is compressed becomes buffers of ours, which the JSON then points to.
absl::Status Decompress(const SceneLoadLimits& limits, Gltf* gltf);

// EXT_meshopt_compression of a buffer: it may have no bytes.
bool IsMeshoptFallback(const Place& buffer);
// EXT_meshopt_compression and KHR_draco_mesh_compression as the JSON says, where the file says that it uses them.
absl::Status CheckMeshoptView(const Gltf& gltf, const Place& view);
absl::Status CheckDracoPrimitive(const Place& primitive, Gltf* gltf);
// weights of a mesh or a node.
absl::Status CheckWeights(const Place& owner);
// KHR_texture_transform of a texture info.
absl::Status CheckTextureTransform(const Place& info);
// EXT_mesh_gpu_instancing and KHR_lights_punctual of a node.
absl::Status CheckNodeExtensions(const Gltf& gltf, const Place& node, Warnings* warnings);
// The lights that KHR_lights_punctual has at the root.
absl::Status CheckLights(const Gltf& gltf, Warnings* warnings);
absl::Status CheckAnimation(const Gltf& gltf, const Place& animation, Warnings* warnings);

// Bytes of one component: 1, 2 or 4; 0 for an unknown componentType.
int ComponentBytes(int64_t component_type);
// Bytes that one element covers, and from one element to the next where nothing else is said: columns of matrices start
// at multiples of four. 0 for an unknown type.
int ElementBytes(const std::string& type, int64_t component_type);
int PackedStride(const std::string& type, int64_t component_type);

}  // namespace halfshade
