#include "renderer/light/light_shaft.h"

#include <algorithm>
#include <cmath>

namespace halfshade {
namespace {

constexpr double kSlack = 1.0 / 131072;

}  // namespace

LightShaft::LightShaft(const std::array<glm::dvec3, 4>& light, const Box3d& receivers) {
  std::array<glm::dvec3, 12> points;  // the light's, then the box's
  std::copy(light.begin(), light.end(), points.begin());
  for (int i = 0; i < 8; ++i) {
    points[4 + i] = {i & 1 ? receivers.max.x : receivers.min.x, i & 2 ? receivers.max.y : receivers.min.y,
                     i & 4 ? receivers.max.z : receivers.min.z};
  }
  double size = 1;
  for (const glm::dvec3& point : points) {
    size = std::max({size, std::abs(point.x), std::abs(point.y), std::abs(point.z)});
  }
  const double slack = kSlack * size;
  const auto most = [&](const glm::dvec3& normal) {
    double value = glm::dot(normal, points[0]);
    for (const glm::dvec3& point : points) value = std::max(value, glm::dot(normal, point));
    return value;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      glm::dvec3 normal(0);
      normal[axis] = sign;
      sides_.push_back({normal, most(normal) + slack});
    }
    // Seen along the axis: lines from a corner of the light to one of the box that have all on one side.
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i < 4; ++i) {
      for (int k = 4; k < 12; ++k) {
        const glm::dvec3 along = points[k] - points[i];
        const double length = std::hypot(along[u], along[v]);
        if (length <= slack || (k > 4 && points[k][u] == points[k - 1][u] && points[k][v] == points[k - 1][v]))
          continue;
        for (const double sign : {-1.0, 1.0}) {
          glm::dvec3 normal(0);
          normal[u] = sign * along[v] / length;
          normal[v] = -sign * along[u] / length;
          const double here = glm::dot(normal, points[i]), furthest = most(normal);
          if (furthest <= here + slack) sides_.push_back({normal, furthest + slack});
        }
      }
    }
  }
}

bool LightShaft::Misses(const Box3f& box) const {
  return std::any_of(sides_.begin(), sides_.end(), [&](const Side& side) {
    const glm::dvec3 nearest(side.normal.x > 0 ? box.min.x : box.max.x, side.normal.y > 0 ? box.min.y : box.max.y,
                             side.normal.z > 0 ? box.min.z : box.max.z);
    return glm::dot(side.normal, nearest) > side.most;
  });
}

}  // namespace halfshade
