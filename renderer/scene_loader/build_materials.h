// Images, textures and materials of a glTF, for the flat scene.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/flat_scene.h"
#include "renderer/scene_loader/accessor_reader.h"
#include "renderer/scene_loader/gltf_json.h"
#include "renderer/scene_loader/scene_loader.h"

namespace halfshade {

// What FlatScene::texcoords, or texcoords1, of a material's meshes hold: a set of the file's, transformed.
struct TexcoordSource {
  bool is_used = false;
  int set = 0;              // TEXCOORD_n
  glm::dmat3 transform{1};  // KHR_texture_transform
  bool operator==(const TexcoordSource&) const = default;
};
using TexcoordSources = std::array<TexcoordSource, 2>;

// Appends them, last glTF's default material; of each material what its meshes' texture coordinates are. Images that we
// cannot read are left out, and materials keep their factors alone, with a warning.
std::vector<TexcoordSources> BuildMaterials(const GltfData& data, const SceneLoadLimits& limits, Gltf* gltf,
                                            FlatScene* scene);

}  // namespace halfshade
