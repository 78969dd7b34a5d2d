// Irradiance from an unshadowed area light, in double: what shaders/common/form_factor.glsl computes in float.
#pragma once

#include <glm/glm.hpp>

namespace halfshade {

// A rectangle |x| <= half_edges.x, |y| <= half_edges.y, z = 0 of radiance 1 that emits toward +z, seen from `position`
// with the unit normal `normal`; clipped to the receiver's horizon. 0 behind the light. Lambert's formula (1760); in
// [0, pi]. Relative error about 1e-16 over the angle that the light spans.
double RectangleIrradiance(const glm::dvec2& half_edges, const glm::dvec3& position, const glm::dvec3& normal);

// A point at the origin of intensity 1 along +z, falling with the cosine.
double PointIrradiance(const glm::dvec3& position, const glm::dvec3& normal);

// A line from -half_edge to half_edge (z = 0) of intensity 1 along +z, spread evenly over its length, falling with the
// cosine; cut at the receiver's horizon. The integral of PointIrradiance in closed form; half_edge 0 is the point.
double LineIrradiance(const glm::dvec2& half_edge, const glm::dvec3& position, const glm::dvec3& normal);

}  // namespace halfshade
