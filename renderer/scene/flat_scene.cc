#include "renderer/scene/flat_scene.h"

namespace halfshade {
namespace {

template <typename T>
size_t ArrayBytes(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

}  // namespace

MaskCoverage FlatScene::CoverageOf(const Mesh& mesh) const {
  const Material& material = materials[mesh.material];
  // Alpha is a product of factors in [0,1].
  if (material.alpha_mode != AlphaMode::kMask || material.alpha_cutoff <= 0) return MaskCoverage::kFull;
  if (material.base_color.a < material.alpha_cutoff) return MaskCoverage::kNothing;
  const bool varies = material.base_color_texture.texture >= 0 || !colors.empty();
  return varies ? MaskCoverage::kTested : MaskCoverage::kFull;
}

size_t FlatScene::SizeBytes() const {
  size_t bytes = sizeof(FlatScene) + ArrayBytes(positions) + ArrayBytes(normals) + ArrayBytes(texcoords) +
                 ArrayBytes(texcoords1) + ArrayBytes(tangents) + ArrayBytes(colors) + ArrayBytes(indices) +
                 ArrayBytes(meshes) + ArrayBytes(clusters) + ArrayBytes(materials) + ArrayBytes(textures) +
                 ArrayBytes(images) + ArrayBytes(nodes) + ArrayBytes(cameras) + ArrayBytes(scenes) +
                 ArrayBytes(warnings);
  for (const EncodedImage& image : images) bytes += image.bytes.size() + image.name.size();
  for (const Node& node : nodes) bytes += node.name.size();
  for (const Material& material : materials) bytes += material.name.size();
  for (const SceneCamera& camera : cameras) bytes += camera.name.size();
  for (const SceneRoots& roots : scenes) bytes += roots.name.size() + ArrayBytes(roots.roots);
  for (const std::string& warning : warnings) bytes += warning.size();
  return bytes;
}

}  // namespace halfshade
