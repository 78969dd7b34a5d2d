// How the triangles of occluders hang together: which of them form closed surfaces, and which share an edge.
//
// Vertices are welded by position first: a mesh is closed where the seams of its texture are not. Pure; no GL.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace halfshade {

inline constexpr uint32_t kNoTriangle = ~0u;

struct Topology {
  // Of each triangle: its surface is 0: open, 1: closed, 2: closed, but with its corners in the order that makes the
  // enclosed volume negative. Closed is a set of triangles, connected through edges, that uses each edge as often in
  // one direction as in the other: then a segment between two points outside crosses it outward as often as inward.
  std::vector<uint8_t> closed;
  // The one other triangle across edge k (from corner k to the next), where there is exactly one and it runs the other
  // way; else kNoTriangle. [triangle][3]
  std::vector<uint32_t> neighbours;
  std::vector<uint32_t> welded;  // of each vertex the first at its place
};

// `indices`: three a triangle, into `positions`. A triangle that crosses or touches light_z < least_z makes its surface
// an open one: the light may stand inside.
Topology FindTopology(const std::vector<glm::vec3>& positions, const std::vector<uint32_t>& indices, float least_z);

}  // namespace halfshade
