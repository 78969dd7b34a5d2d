// A dense mesh with fewer triangles, each level with what it is off by: a product of the scene alone, for occluders
// that stand so far from their receivers that the difference does not show.
//
// Vertices are welded by position, and no new ones made: a level is a list of indices. Edges that a mesh has on one
// side only keep their vertices, so that meshes that meet there go on meeting; collapses turn closed surfaces into
// closed ones. Immutable once made. No GL.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/flat_scene.h"

namespace halfshade {

struct MeshLevel {
  std::vector<uint32_t> indices;  // three a triangle, relative to Mesh::first_vertex
  float error = 0;                // in the mesh's lengths: of its surface from the mesh's, root of a quadric
};

// Finest first, the mesh itself is not among them; none where it is not dense, masked, or cannot be simpler. Each level
// a quarter of the triangles of the one before (meshoptimizer: quadric edge collapses, Garland and Heckbert 1997), as
// long as that can be done within a 32nd of the mesh's extent.
std::vector<MeshLevel> BuildMeshLevels(const FlatScene& scene, const Mesh& mesh);

}  // namespace halfshade
