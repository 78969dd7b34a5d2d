// A mesh that hides a light from many places: its faces once, in its own frame, and how each place takes them into
// shaft space. Polygons of an instance are made where a shaft meets them, and are to the bit those of a copy.
//
// No light and no camera enters the shape. Pure; no GL.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/light/shared_meshes.h"
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
  uint32_t shape = 0;
  bool is_mirrored = false;
};

// `levels`: null, or of all meshes.
MeshShape MakeMeshShape(const SharedMesh& mesh, const MeshLevels* levels);

// `shape_index`: of the shape, in a list of them.
ShapeInstance MakeShapeInstance(const MeshShape& shape, uint32_t shape_index, const SharedMesh::Place& place,
                                const ShaftSpace& space);

// False where a face of the shape has no area there.
bool MakePolygon(const ShapeInstance& instance, const Face& face, const ShaftSpace& space, Polygon* polygon);

}  // namespace halfshade
