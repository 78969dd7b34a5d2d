#include "renderer/math/form_factor.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace halfshade {

// Clipped and walked in the light's plane: an edge is a difference of points of the light, which is exact for small
// lights, and vectors to the receiver are never normalised. So the sum loses 1 / angle in precision, not 1 / angle^2.
double RectangleIrradiance(const glm::dvec2& half_edges, const glm::dvec3& position, const glm::dvec3& normal) {
  if (position.z <= 0) return 0;
  const glm::dvec2 corners[4] = {{-half_edges.x, -half_edges.y},
                                 {half_edges.x, -half_edges.y},
                                 {half_edges.x, half_edges.y},
                                 {-half_edges.x, half_edges.y}};
  const auto height = [&](const glm::dvec2& p) { return glm::dot(glm::dvec3(p, 0) - position, normal); };
  std::vector<glm::dvec2> polygon;  // of the light above the receiver's horizon
  for (int i = 0; i < 4; ++i) {
    const glm::dvec2 a = corners[i];
    const glm::dvec2 b = corners[(i + 1) % 4];
    const double height_a = height(a);
    const double height_b = height(b);
    if (height_a >= 0) polygon.push_back(a);
    if ((height_a >= 0) != (height_b >= 0)) polygon.push_back(a + (b - a) * (height_a / (height_a - height_b)));
  }
  double sum = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2 edge = polygon[(i + 1) % polygon.size()] - polygon[i];
    const glm::dvec3 a = glm::dvec3(polygon[i], 0) - position;
    const glm::dvec3 across = glm::cross(a, glm::dvec3(edge, 0));
    const double size = glm::length(across);
    if (size > 0) sum += std::atan2(size, glm::dot(a, a + glm::dvec3(edge, 0))) / size * glm::dot(across, normal);
  }
  return 0.5 * std::abs(sum);
}

double PointIrradiance(const glm::dvec3& position, const glm::dvec3& normal) {
  const double distance2 = glm::dot(position, position);
  return std::max(-glm::dot(position, normal), 0.0) * std::max(position.z, 0.0) / (distance2 * distance2);
}

// With s the distance along the line from the receiver's foot on it, and d the receiver's distance from the line, the
// irradiance is z / (2 reach) times the integral of (slope s + height) / (s^2 + d^2)^2. Its antiderivative is taken as
// a difference that does not cancel where the line is short.
double LineIrradiance(const glm::dvec2& half_edge, const glm::dvec3& position, const glm::dvec3& normal) {
  const double reach = glm::length(half_edge);
  if (reach == 0) return PointIrradiance(position, normal);
  if (position.z <= 0) return 0;
  const glm::dvec3 along(half_edge / reach, 0);
  const double foot = glm::dot(along, position);
  const glm::dvec3 to_line = along * foot - position;
  const double slope = glm::dot(along, normal);
  const double height = glm::dot(to_line, normal);  // of the foot above the receiver's plane
  double from = -reach;                             // along the line from its centre
  double to = reach;
  if (slope > 0) from = std::max(from, foot - height / slope);
  if (slope < 0) to = std::min(to, foot - height / slope);
  if (from >= to || (slope == 0 && height <= 0)) return 0;
  const double length = to - from;
  const double low = from - foot;
  const double high = to - foot;
  const double d2 = glm::dot(to_line, to_line);
  const double d = std::sqrt(d2);
  const double squares = (low * low + d2) * (high * high + d2);
  const double angle = std::atan2(length * d, d2 + low * high);
  const double integral = slope / 2 * length * (high + low) / squares +
                          height / (2 * d2) * (length * (d2 - low * high) / squares + angle / d);
  return std::max(0.0, position.z / (2 * reach) * integral);
}

}  // namespace halfshade
