// Meshes that are kept for all lights: their faces once, in their own frame, and how each place takes them into shaft
// space. Polygons of an instance are made where a shaft meets them, and are to the bit those of a copy.
//
// No light and no camera enters a shape. Pure; no GL.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/light/kept_meshes.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/mesh_levels.h"
#include "renderer/shadow/shaft/box_tree.h"
#include "renderer/shadow/shaft/polygons.h"

namespace halfshade {

// The faces of a leaf, as arrays.
struct alignas(64) Faces16 {
  float corners[4][3][16];                    // [corner][axis]
  uint32_t used = 0, closed = 0, turned = 0;  // bit per face; turned: Topology::closed is 2
  uint32_t quads = 0;
  Face At(uint32_t lane) const;
};

struct MeshShape {
  std::vector<Faces16> faces;   // item 16 i + k of a leaf is face k of the i-th
  std::vector<TreeRoot> roots;  // of the mesh and its levels, finest first; lengths are the mesh's
  std::vector<TreeNode> nodes;
  glm::vec3 reach{0};  // largest |x|, |y|, |z| of a corner
  uint64_t SizeBytes() const {
    return faces.size() * sizeof(Faces16) + roots.size() * sizeof(TreeRoot) + nodes.size() * sizeof(TreeNode);
  }
};

struct ShapeInstance {
  glm::dmat4 light_from_mesh;
  // Shaft space from mesh: for boxes, which are enlarged by `slack`, above what rounding does to both.
  float axes[3][3], origin[3], slack[3];  // axes[column][row]
  float scale = 1;                        // metres that a level's error of 1 is off by
  float stretch = 1;                      // metres that a length of 1 has at most
  const MeshShape* shape = nullptr;
  float z_near = 0;  // what is nearer to the light's plane is cut off
  bool is_mirrored = false;
  bool is_cut = false;  // some of it is, and its surfaces are no closed ones: the light may stand inside
};

// `levels`: of this mesh; none: it has none.
MeshShape MakeMeshShape(const FlatScene& scene, const Mesh& mesh, const std::vector<MeshLevel>& levels);

// Of a scene.
struct MeshShapes {
  std::vector<uint32_t> kept_meshes;  // FindKeptMeshes
  std::vector<MeshShape> shapes;      // [mesh], of those that are kept
  uint64_t SizeBytes() const;
};

// On all threads. The error of `stop` comes back.
absl::StatusOr<MeshShapes> BuildMeshShapes(const FlatScene& scene, const std::function<absl::Status()>& stop);

// The shape lives as long as the instance.
ShapeInstance MakeShapeInstance(const MeshShape& shape, const KeptPlace& place, float z_near, const ShaftSpace& space);

// Of a face of the shape. None where it has no area there.
PolygonParts MakePolygons(const ShapeInstance& instance, const Face& face, const ShaftSpace& space);

}  // namespace halfshade
