#include "tests/support/closed_forms.h"

#include <algorithm>

#include "renderer/math/horizon.h"

namespace halfshade {
namespace {

// Share of [-half, half] that [low, high] covers; of a point, 0 or 1.
double CoveredShare(double half, double low, double high) {
  if (half == 0) return low <= 0 && 0 <= high ? 1 : 0;
  return std::max(0.0, std::min(high, half) - std::max(low, -half)) / (2 * half);
}

}  // namespace

double VisibilityBehindPlate(const glm::dvec2& half_edges, const glm::dvec3& center, const glm::dvec2& half_size,
                             const glm::dvec3& receiver) {
  if (center.z >= receiver.z) return 1;
  // From the receiver a point at z = center.z falls on the light enlarged by receiver.z over the distance between them.
  const double enlargement = receiver.z / (receiver.z - center.z);
  double hidden = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double middle = receiver[axis] + (center[axis] - receiver[axis]) * enlargement;
    const double reach = half_size[axis] * enlargement;
    hidden *= CoveredShare(half_edges[axis], middle - reach, middle + reach);
  }
  return 1 - hidden;
}

double VisibilityBehindHalfPlane(const glm::dvec2& half_edges, const glm::dvec2& normal, double offset, double edge_z,
                                 const glm::dvec3& receiver) {
  if (edge_z >= receiver.z) return 1;
  const double at_receiver = glm::dot(normal, glm::dvec2(receiver));
  const double on_light = at_receiver + (offset - at_receiver) * receiver.z / (receiver.z - edge_z);
  return 1 - ShareAbovePlane(half_edges, {normal, 0}, on_light);
}

double SphereHorizonShare(const glm::dvec2& half_edges, const glm::dvec3& center, double radius,
                          const glm::dvec3& direction) {
  return ShareAbovePlane(half_edges, direction, glm::dot(direction, center) + radius);
}

}  // namespace halfshade
