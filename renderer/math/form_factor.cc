#include "renderer/math/form_factor.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace halfshade {

double RectangleIrradiance(const glm::dvec2& half_edges, const glm::dvec3& position, const glm::dvec3& normal) {
  if (position.z <= 0) return 0;
  const glm::dvec3 corners[4] = {{-half_edges.x, -half_edges.y, 0},
                                 {half_edges.x, -half_edges.y, 0},
                                 {half_edges.x, half_edges.y, 0},
                                 {-half_edges.x, half_edges.y, 0}};
  std::vector<glm::dvec3> polygon;  // relative to the receiver, above its horizon
  for (int i = 0; i < 4; ++i) {
    const glm::dvec3 a = corners[i] - position;
    const glm::dvec3 b = corners[(i + 1) % 4] - position;
    const double height_a = glm::dot(a, normal);
    const double height_b = glm::dot(b, normal);
    if (height_a >= 0) polygon.push_back(a);
    if ((height_a >= 0) != (height_b >= 0)) polygon.push_back(glm::mix(a, b, height_a / (height_a - height_b)));
  }
  double sum = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec3 a = glm::normalize(polygon[i]);
    const glm::dvec3 b = glm::normalize(polygon[(i + 1) % polygon.size()]);
    const glm::dvec3 across = glm::cross(a, b);
    const double sine = glm::length(across);
    if (sine > 0) sum += std::atan2(sine, glm::dot(a, b)) / sine * glm::dot(across, normal);
  }
  return 0.5 * std::abs(sum);
}

double PointIrradiance(const glm::dvec3& position, const glm::dvec3& normal) {
  const double distance2 = glm::dot(position, position);
  return std::max(-glm::dot(position, normal), 0.0) * std::max(position.z, 0.0) / (distance2 * distance2);
}

}  // namespace halfshade
