#include "renderer/math/horizon.h"

#include <algorithm>
#include <cmath>

namespace halfshade {

double ShareAbovePlane(const glm::dvec2& half_edges, const glm::dvec3& normal, double offset) {
  const glm::dvec2 reach = glm::abs(glm::dvec2(normal)) * half_edges;
  const double spread = reach.x + reach.y;
  const double height = -offset;  // of the centre, above the plane
  if (height >= spread) return height > 0 ? 1 : 0;
  if (height <= -spread) return 0;
  const double small = std::min(reach.x, reach.y) / spread;
  const double large = std::max(reach.x, reach.y) / spread;
  const double level = (spread - std::abs(height)) / (2 * spread);  // in [0, 1/2]: the smaller part
  const double part = level < small ? level * level / (2 * small * large) : (level - small / 2) / large;
  return height > 0 ? 1 - part : part;
}

}  // namespace halfshade
