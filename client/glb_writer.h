// Writes a GLB from plain meshes: for OBJ files at the client and for generated scenes in tests, bench and demo.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace halfshade {

// One mesh with one material, under one node. World metres, y up.
struct GlbMesh {
  std::string name;
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;             // empty, or one per position, unit
  std::vector<glm::vec2> texcoords;           // empty, or one per position
  std::vector<uint32_t> indices;              // triangles
  glm::vec4 base_color{0.8f, 0.8f, 0.8f, 1};  // linear
  bool is_double_sided = false;
  glm::dmat4 world_from_mesh{1};
};

// What the meshes may take, so that the file with its JSON stays under the 4 GiB of its 32-bit lengths.
inline constexpr size_t kMaxGlbBytes = 4'000'000'000;

// The file's bytes. The same input gives the same bytes; meshes without triangles are left out. Requires valid indices
// and at most kMaxGlbBytes of vertices and indices (asserted).
std::string WriteGlb(const std::vector<GlbMesh>& meshes);

}  // namespace halfshade
