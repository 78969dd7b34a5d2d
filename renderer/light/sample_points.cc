#include "renderer/light/sample_points.h"

#include "renderer/math/sampling.h"

namespace halfshade {

std::vector<glm::dvec2> SobolLightPoints(const AreaLight& light, int k, uint32_t seed) {
  if (light.width_m == 0 && light.height_m == 0) return {glm::dvec2(0)};
  std::vector<glm::dvec2> points;
  points.reserve(k);
  for (int i = 0; i < k; ++i) {
    const glm::dvec2 unit = OwenSobol2(uint32_t(i), seed);
    points.emplace_back((unit.x - 0.5) * light.width_m, (unit.y - 0.5) * light.height_m);
  }
  return points;
}

}  // namespace halfshade
