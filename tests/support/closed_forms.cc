#include "tests/support/closed_forms.h"

#include <algorithm>
#include <vector>

#include "renderer/math/horizon.h"

namespace halfshade {
namespace {

// Share of [-half, half] that [low, high] covers; of a point, 0 or 1.
double CoveredShare(double half, double low, double high) {
  if (half == 0) return low <= 0 && 0 <= high ? 1 : 0;
  return std::max(0.0, std::min(high, half) - std::max(low, -half)) / (2 * half);
}

double Cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

// Counter-clockwise (Andrew's monotone chain).
std::vector<glm::dvec2> ConvexHull(std::vector<glm::dvec2> points) {
  std::sort(points.begin(), points.end(),
            [](const glm::dvec2& a, const glm::dvec2& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  std::vector<glm::dvec2> hull;
  for (int half = 0; half < 2; ++half) {
    const size_t begin = hull.size();
    for (const glm::dvec2& p : points) {
      while (hull.size() >= begin + 2 && Cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();  // it begins the other half
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

// The part of a polygon with sign * p[axis] <= bound.
std::vector<glm::dvec2> Clip(const std::vector<glm::dvec2>& polygon, int axis, double sign, double bound) {
  std::vector<glm::dvec2> clipped;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2& a = polygon[i];
    const glm::dvec2& b = polygon[(i + 1) % polygon.size()];
    const double inside_a = bound - sign * a[axis];
    const double inside_b = bound - sign * b[axis];
    if (inside_a >= 0) clipped.push_back(a);
    if ((inside_a < 0) != (inside_b < 0)) clipped.push_back(glm::mix(a, b, inside_a / (inside_a - inside_b)));
  }
  return clipped;
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

double VisibilityBehindBox(const glm::dvec2& half_edges, const glm::dvec3& low, const glm::dvec3& high,
                           const glm::dvec3& receiver) {
  std::vector<glm::dvec2> corners;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
    corners.emplace_back(glm::dvec2(receiver) + glm::dvec2(corner - receiver) * (receiver.z / (receiver.z - corner.z)));
  }
  std::vector<glm::dvec2> hidden = ConvexHull(corners);
  for (int axis = 0; axis < 2; ++axis) {
    for (const double sign : {-1.0, 1.0}) hidden = Clip(hidden, axis, sign, half_edges[axis]);
  }
  double twice_area = 0;
  for (size_t i = 0; i < hidden.size(); ++i) twice_area += Cross(hidden[i], hidden[(i + 1) % hidden.size()]);
  return 1 - twice_area / (8 * half_edges.x * half_edges.y);
}

double SphereHorizonShare(const glm::dvec2& half_edges, const glm::dvec3& center, double radius,
                          const glm::dvec3& direction) {
  return ShareAbovePlane(half_edges, direction, glm::dot(direction, center) + radius);
}

}  // namespace halfshade
