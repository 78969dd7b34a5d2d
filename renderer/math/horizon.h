// The share of a light above a receiver's tangent plane.
#pragma once

#include <glm/glm.hpp>

namespace halfshade {

// Share, in [0,1], of the rectangle |x| <= half_edges.x, |y| <= half_edges.y, z = 0 with normal . x > offset. Exact:
// the area under a line of the unit square, as in volume-of-fluid methods. A zero edge makes a line, two a point (0 or
// 1). The twin in shaders/common/horizon.glsl is held to this one by a test.
double ShareAbovePlane(const glm::dvec2& half_edges, const glm::dvec3& normal, double offset);

}  // namespace halfshade
