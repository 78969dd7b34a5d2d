#include "renderer/scene/flat_scene.h"

#include <algorithm>

namespace halfshade {
namespace {

template <typename T>
size_t ArrayBytes(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

}  // namespace

MaskCoverage FlatScene::CoverageOf(const Mesh& mesh) const {
  const Material& material = materials[mesh.material];
  if (material.alpha_mode != AlphaMode::kBlend) return SeenCoverageOf(mesh);
  if (material.base_color.a <= 0) return MaskCoverage::kNothing;
  const bool varies = material.base_color_texture.texture >= 0 || !colors.empty();
  return material.base_color.a >= 1 && !varies ? MaskCoverage::kFull : MaskCoverage::kTested;
}

MaskCoverage FlatScene::SeenCoverageOf(const Mesh& mesh) const {
  const Material& material = materials[mesh.material];
  // Alpha is a product of factors in [0,1].
  if (material.alpha_mode == AlphaMode::kOpaque || material.alpha_cutoff <= 0) return MaskCoverage::kFull;
  if (material.base_color.a < material.alpha_cutoff) return MaskCoverage::kNothing;
  const bool varies = material.base_color_texture.texture >= 0 || !colors.empty();
  return varies ? MaskCoverage::kTested : MaskCoverage::kFull;
}

Cluster FlatScene::MakeCluster(const Mesh& mesh, uint32_t index) const {
  Cluster cluster;
  cluster.first_triangle = index * Cluster::kMaxTriangles;
  cluster.triangle_count = std::min(Cluster::kMaxTriangles, mesh.TriangleCount() - cluster.first_triangle);
  for (uint32_t i = 3 * cluster.first_triangle; i < 3 * (cluster.first_triangle + cluster.triangle_count); ++i) {
    cluster.bounds.Add(positions[mesh.first_vertex + indices[mesh.first_index + i]]);
  }
  return cluster;
}

size_t FlatScene::SizeBytes() const {
  size_t bytes =
      sizeof(FlatScene) + ArrayBytes(positions) + ArrayBytes(normals) + ArrayBytes(texcoords) + ArrayBytes(texcoords1) +
      ArrayBytes(tangents) + ArrayBytes(colors) + ArrayBytes(indices) + ArrayBytes(meshes) + ArrayBytes(clusters) +
      ArrayBytes(materials) + ArrayBytes(textures) + ArrayBytes(images) + ArrayBytes(nodes) + ArrayBytes(cameras) +
      ArrayBytes(scenes) + ArrayBytes(warnings) + ArrayBytes(places) + ArrayBytes(morph_weights) + ArrayBytes(skins) +
      ArrayBytes(skin_joints) + ArrayBytes(joint_from_mesh) + ArrayBytes(deformed) + ArrayBytes(bind_vertices) +
      ArrayBytes(bind_indices) + ArrayBytes(influences) + ArrayBytes(morph_deltas) + ArrayBytes(animations) +
      ArrayBytes(channels) + ArrayBytes(animation_times) + ArrayBytes(animation_values) + ArrayBytes(rests);
  for (const Animation& animation : animations) bytes += animation.name.size();
  for (const EncodedImage& image : images) bytes += image.bytes.size() + image.name.size();
  for (const Node& node : nodes) bytes += node.name.size();
  for (const Material& material : materials) bytes += material.name.size();
  for (const SceneCamera& camera : cameras) bytes += camera.name.size();
  for (const SceneRoots& roots : scenes) bytes += roots.name.size() + ArrayBytes(roots.roots);
  for (const std::string& warning : warnings) bytes += warning.size();
  return bytes;
}

}  // namespace halfshade
