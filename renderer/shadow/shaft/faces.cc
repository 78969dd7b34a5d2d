#include "renderer/shadow/shaft/faces.h"

#include <algorithm>
#include <cmath>

namespace halfshade {
namespace {

constexpr double kUlp = 1.1920929e-7;
// Of a level's edges, in means of them.
constexpr double kLongestEdge = 3;

// In parts, until no edge is longer.
void AddInParts(const Face& triangle, float longest_edge, std::vector<Face>* faces) {
  size_t longest = 0;
  float length = 0;
  for (size_t k = 0; k < 3; ++k) {
    const glm::vec3 &a = triangle.corners[k], &b = triangle.corners[(k + 1) % 3];
    // The same of both triangles beside it.
    const float edge = glm::length(glm::abs(a - b));
    if (edge > length) {
      longest = k;
      length = edge;
    }
  }
  if (!(length > longest_edge)) {
    faces->push_back(triangle);
    return;
  }
  const glm::vec3 &a = triangle.corners[longest], &b = triangle.corners[(longest + 1) % 3],
                  &c = triangle.corners[(longest + 2) % 3];
  const glm::vec3 middle = (a + b) * 0.5f;
  AddInParts({{a, middle, c, c}, 3, triangle.closed}, longest_edge, faces);
  AddInParts({{middle, b, c, c}, 3, triangle.closed}, longest_edge, faces);
}

}  // namespace

FaceFinder::FaceFinder(const std::vector<glm::vec3>& positions, const std::vector<uint32_t>& indices, float least_z)
    : positions_(positions),
      indices_(indices),
      topology_(FindTopology(positions, indices, least_z)),
      is_done_(indices.size() / 3, false) {}

std::vector<Face> FaceFinder::Find(uint32_t first, uint32_t last, uint32_t end) {
  std::vector<Face> faces;
  faces.reserve(last - first);
  for (uint32_t t = first; t < last; ++t) {
    if (is_done_[t]) continue;
    is_done_[t] = true;
    Face face = {{Corner(t, 0), Corner(t, 1), Corner(t, 2), Corner(t, 2)}, 3, topology_.closed[t]};
    for (uint32_t k = 0; k < 3 && face.count == 3; ++k) {
      const uint32_t other = topology_.neighbours[3 * t + k];
      if (other == kNoTriangle || other >= end || is_done_[other]) continue;
      if (AddFourth(t, k, other, &face)) is_done_[other] = true;
    }
    faces.push_back(face);
  }
  return faces;
}

// Of the neighbour across edge k, if the four make a plane convex quad.
bool FaceFinder::AddFourth(uint32_t t, uint32_t k, uint32_t other, Face* face) const {
  const glm::dvec3 begin = Corner(t, k), end = Corner(t, k + 1), own = Corner(t, k + 2);
  // Its corner that is neither.
  glm::vec3 fourth_corner = Corner(other, 0);
  for (uint32_t j = 1; j < 3; ++j) {
    if (glm::dvec3(fourth_corner) == begin || glm::dvec3(fourth_corner) == end) fourth_corner = Corner(other, j);
  }
  const glm::dvec3 fourth = fourth_corner;
  const glm::dvec3 normal = glm::cross(end - begin, own - begin);
  const double length = glm::length(normal);
  if (length == 0) return false;
  const Face quad = {{Corner(t, k + 2), Corner(t, k), fourth_corner, Corner(t, k + 1)}, 4, face->closed};
  // Plane as far as the corners are known, and to a millionth of its size: less than any sample sees.
  const double extent = std::max(glm::length(end - begin), glm::length(fourth - own));
  const double most = 4 * kUlp * double(SizeOf(quad.corners)) + 1e-6 * extent;
  if (std::abs(glm::dot(normal, fourth - begin)) / length > most) return false;
  const bool turns_at_begin = glm::dot(glm::cross(begin - own, fourth - begin), normal) > 0;
  const bool turns_at_end = glm::dot(glm::cross(end - fourth, own - end), normal) > 0;
  const bool turns_at_fourth = glm::dot(glm::cross(fourth - begin, end - fourth), normal) > 0;
  if (!turns_at_begin || !turns_at_end || !turns_at_fourth) return false;
  *face = quad;
  return true;
}

// A vertex is of a closed surface where all its triangles are; a triangle where all its corners are, one way.
const std::vector<uint8_t>& FaceFinder::ClosedVertices() {
  if (!closed_vertices_.empty()) return closed_vertices_;
  constexpr uint8_t kUnknown = 255;
  closed_vertices_.assign(positions_.size(), kUnknown);
  for (size_t i = 0; i < indices_.size(); ++i) {
    uint8_t& closed = closed_vertices_[topology_.welded[indices_[i]]];
    const uint8_t here = topology_.closed[i / 3];
    closed = closed == kUnknown || closed == here ? here : 0;
  }
  return closed_vertices_;
}

std::vector<Face> FaceFinder::FindOfLevel(const std::vector<uint32_t>& indices, uint32_t first_vertex) {
  const std::vector<uint8_t>& closed = ClosedVertices();
  double mean_edge = 0;
  for (size_t i = 0; i < indices.size(); i += 3) {
    const auto corner = [&](size_t k) { return positions_[first_vertex + indices[i + k % 3]]; };
    for (size_t k = 0; k < 3; ++k) mean_edge += glm::distance(corner(k), corner(k + 1));
  }
  const auto longest_edge = float(kLongestEdge * mean_edge / double(indices.size()));
  std::vector<Face> faces;
  faces.reserve(indices.size() / 3);
  for (size_t i = 0; i < indices.size(); i += 3) {
    Face face;
    uint8_t all = 255;
    for (int k = 0; k < 3; ++k) {
      const uint32_t vertex = first_vertex + indices[i + k];
      face.corners[k] = positions_[vertex];
      const uint8_t here = closed[topology_.welded[vertex]];
      all = all == 255 || all == here ? here : 0;
    }
    face.corners[3] = face.corners[2];
    face.closed = all == 255 ? 0 : all;
    AddInParts(face, longest_edge, &faces);
  }
  return faces;
}

}  // namespace halfshade
