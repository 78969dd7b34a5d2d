// Irradiance from an unshadowed area light, in double: what shaders/common/form_factor.glsl computes in float.
#pragma once

#include <glm/glm.hpp>

namespace halfshade {

// A rectangle |x| <= half_edges.x, |y| <= half_edges.y, z = 0 of radiance 1 that emits toward +z, seen from `position`
// with the unit normal `normal`; clipped to the receiver's horizon. 0 behind the light. Lambert's formula (1760); in
// [0, pi].
double RectangleIrradiance(const glm::dvec2& half_edges, const glm::dvec3& position, const glm::dvec3& normal);

// A point at the origin of intensity 1 along +z, falling with the cosine.
double PointIrradiance(const glm::dvec3& position, const glm::dvec3& normal);

}  // namespace halfshade
