// Visibilities that have a closed form. Light frame (renderer/math/light_frame.h), metres, double; visibility in [0,1]
// is the share of the light's area that a receiver sees, its horizon left out but in SphereHorizonShare. The light is
// |x| <= half_edges.x, |y| <= half_edges.y at z = 0; receivers stand at z > 0. A zero edge makes a line, two a point.
#pragma once

#include <glm/glm.hpp>

namespace halfshade {

// Behind a rectangle parallel to the light and aligned with it: |x - center.x| <= half_size.x, the same in y, at
// z = center.z > 0. A rectangle at or beyond the receiver hides nothing.
double VisibilityBehindPlate(const glm::dvec2& half_edges, const glm::dvec3& center, const glm::dvec2& half_size,
                             const glm::dvec3& receiver);

// Behind the half plane normal . (x, y) > offset at z = edge_z > 0, parallel to the light. normal: any length but 0.
double VisibilityBehindHalfPlane(const glm::dvec2& half_edges, const glm::dvec2& normal, double offset, double edge_z,
                                 const glm::dvec3& receiver);

// Behind a box low <= x <= high with 0 < low.z and high.z < receiver.z: its silhouette on the light is the convex hull
// of its corners as the receiver sees them.
double VisibilityBehindBox(const glm::dvec2& half_edges, const glm::dvec3& low, const glm::dvec3& high,
                           const glm::dvec3& receiver);

// The share of the light above the tangent plane of a sphere at its point in `direction` (unit) from the centre: all
// that a lone sphere hides.
double SphereHorizonShare(const glm::dvec2& half_edges, const glm::dvec3& center, double radius,
                          const glm::dvec3& direction);

}  // namespace halfshade
