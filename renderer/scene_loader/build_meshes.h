// The geometry of a flat scene from the primitives of a glTF.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "renderer/scene/flat_scene.h"
#include "renderer/scene_loader/accessor_reader.h"
#include "renderer/scene_loader/gltf_json.h"
#include "renderer/scene_loader/scene_loader.h"

namespace tinygltf {
struct Primitive;
}

namespace halfshade {

// Metres from the origin that a vertex may have, in its mesh and in the world: float still holds the square.
inline constexpr double kMaxCoordinateM = 1e18;

// Appends primitives to a scene whose materials stand already. Only vertices that a triangle uses are kept, in the
// file's order; triangles without area are dropped and counted; a primitive of which nothing is left makes no mesh.
class MeshBuilder {
 public:
  // All outlive the builder.
  MeshBuilder(const GltfData& data, const SceneLoadLimits& limits, FlatScene* scene, Warnings* warnings)
      : data_(data), limits_(limits), scene_(*scene), warnings_(*warnings) {}

  // INVALID_ARGUMENT for an index past the vertices, a position out of range, or a scene over its limits.
  absl::Status Add(const tinygltf::Primitive& primitive, const std::string& pointer);

 private:
  class Corners;

  // Bounds of the vertices that the primitive names.
  absl::StatusOr<Box3d> Measure(const tinygltf::Primitive& primitive, const Corners& corners,
                                const AccessorReader& positions, const std::string& pointer);
  void AddTriangles(const Corners& corners, const AccessorReader& positions, const glm::dvec3& origin);
  absl::Status AddVertices(const tinygltf::Primitive& primitive, const AccessorReader& positions,
                           const std::string& pointer, Mesh* mesh);
  void AddClusters(Mesh* mesh);

  const GltfData& data_;
  const SceneLoadLimits& limits_;
  FlatScene& scene_;
  Warnings& warnings_;
  uint64_t triangles_read_ = 0;
  std::vector<uint32_t> slots_;  // of a primitive's vertices in the mesh; all 0 between two calls
};

}  // namespace halfshade
