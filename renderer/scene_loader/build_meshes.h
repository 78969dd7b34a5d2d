// The geometry of a flat scene from the primitives of a glTF.
#pragma once

#include <absl/status/statusor.h>

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "renderer/scene/flat_scene.h"
#include "renderer/scene_loader/accessor_reader.h"
#include "renderer/scene_loader/build_materials.h"
#include "renderer/scene_loader/gltf_json.h"
#include "renderer/scene_loader/scene_loader.h"

namespace tinygltf {
struct Primitive;
}

namespace halfshade {

// The node that bends a copy of a mesh.
struct DeformingNode {
  uint32_t node = 0;
  bool has_skin = false;
};

// Appends primitives to a scene whose materials stand already. Only vertices that a triangle uses are kept, in the
// file's order; triangles without area are dropped and counted; a primitive of which nothing is left makes no mesh.
class MeshBuilder {
 public:
  // All outlive the builder.
  MeshBuilder(const GltfData& data, const SceneLoadLimits& limits, const std::vector<TexcoordSources>& texcoords,
              FlatScene* scene, Warnings* warnings)
      : data_(data), limits_(limits), texcoords_(texcoords), scene_(*scene), warnings_(*warnings) {}

  // INVALID_ARGUMENT for an index past the vertices, a position out of range, or a scene over its limits.
  // For a node that deforms it, what bends it is kept too, and triangles without area stay.
  absl::Status Add(const tinygltf::Primitive& primitive, const std::string& pointer,
                   const DeformingNode* deforming = nullptr);

 private:
  class Corners;

  // Bounds of the vertices that the primitive names.
  absl::StatusOr<Box3d> Measure(const tinygltf::Primitive& primitive, const Corners& corners,
                                const AccessorReader& positions, const std::string& pointer);
  void AddTriangles(const Corners& corners, const AccessorReader& positions, const glm::dvec3& origin, bool deforms);
  // Returns the file's numbers of the vertices that were taken, in order.
  absl::StatusOr<std::vector<uint32_t>> AddVertices(const tinygltf::Primitive& primitive,
                                                    const AccessorReader& positions, const std::string& pointer,
                                                    Mesh* mesh);
  absl::Status AddDeformed(const tinygltf::Primitive& primitive, const std::string& pointer,
                           const std::vector<uint32_t>& used, const DeformingNode& deforming, const Mesh& mesh);
  void AddClusters(Mesh* mesh);

  const GltfData& data_;
  const SceneLoadLimits& limits_;
  const std::vector<TexcoordSources>& texcoords_;  // by material
  FlatScene& scene_;
  Warnings& warnings_;
  uint64_t triangles_read_ = 0;
  std::vector<uint32_t> slots_;  // of a primitive's vertices in the mesh; all 0 between two calls
};

}  // namespace halfshade
