// Triangles as convex plane faces: two that form a plane convex quad are one. In any frame; pure; no GL.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/shadow/shaft/topology.h"

namespace halfshade {

// Corners in order; the fourth of a triangle is its third.
struct Face {
  glm::vec3 corners[4];
  uint8_t count = 3;
  uint8_t closed = 0;  // Topology::closed
};

// Largest |x| + |y| + |z| of the corners.
inline float SizeOf(const glm::vec3 (&corners)[4]) {
  double size = 0;
  for (const glm::dvec3 p : corners) size = std::max(size, std::abs(p.x) + std::abs(p.y) + std::abs(p.z));
  return float(size);
}

class FaceFinder {
 public:
  // Both are kept. `least_z`: FindTopology.
  FaceFinder(const std::vector<glm::vec3>& positions, const std::vector<uint32_t>& indices, float least_z);

  // Of triangles [first, last), each with a neighbour before `end` where it forms a quad with it and neither was asked
  // for before.
  std::vector<Face> Find(uint32_t first, uint32_t last, uint32_t end);

  // Of other triangles between the same vertices (MeshLevels), closed where all vertices are. Edges over three means
  // are halved, and those beside them likewise: what is near a receiver and what is far from it then stay apart.
  std::vector<Face> FindOfLevel(const std::vector<uint32_t>& indices, uint32_t first_vertex);

 private:
  const glm::vec3& Corner(uint32_t triangle, uint32_t k) const { return positions_[indices_[3 * triangle + k % 3]]; }
  bool AddFourth(uint32_t t, uint32_t k, uint32_t other, Face* face) const;
  const std::vector<uint8_t>& ClosedVertices();

  const std::vector<glm::vec3>& positions_;
  const std::vector<uint32_t>& indices_;
  const Topology topology_;
  std::vector<bool> is_done_;             // triangles that are part of a face
  std::vector<uint8_t> closed_vertices_;  // at the first vertex of each place
};

}  // namespace halfshade
