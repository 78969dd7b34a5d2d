// What a rectangle of radiance 1 reflects off a GGX surface, twice, in double: by the fitted table, as the shader does,
// and by integration. Light frame: the rectangle |x| <= half_edges.x, |y| <= half_edges.y, z = 0 emits toward +z.
#pragma once

#include <glm/glm.hpp>

namespace halfshade {

struct SurfacePoint {
  glm::dvec3 position{0, 0, 1};
  glm::dvec3 normal{0, 0, -1};  // unit, as is the view
  glm::dvec3 view{0, 0, -1};    // toward the eye
  double roughness = 1;
  double f0 = 1;
};

double SpecularByTable(const glm::dvec2& half_edges, const SurfacePoint& point);

// Importance sampling of GGX by a grid of n x n: each direction either meets the rectangle or not.
double SpecularByIntegration(const glm::dvec2& half_edges, const SurfacePoint& point, int n);

// Reflected from a point at the origin of intensity 1 along +z, falling with the cosine.
double SpecularOfPoint(const SurfacePoint& point);

}  // namespace halfshade
