// Writes a GLB from plain meshes: for OBJ files at the client and for generated scenes in tests, bench and demo.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace halfshade {

// One mesh with one material, under one node. World metres, y up.
struct GlbMesh {
  std::string name;
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;    // empty, or one per position, unit
  std::vector<glm::vec2> texcoords;  // empty, or one per position
  std::vector<uint32_t> indices;     // triangles
  glm::vec4 base_color{0.8f, 0.8f, 0.8f, 1};  // linear
  bool is_double_sided = false;
  glm::dmat4 world_from_mesh{1};
};

// The file's bytes. The same input gives the same bytes. Requires valid indices (asserted).
std::string WriteGlb(const std::vector<GlbMesh>& meshes);

}  // namespace halfshade
