// Points of a light that sampled methods look from. Pure.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/request.h"

namespace halfshade {

// Light frame, metres. The first k points of the Owen-scrambled Sobol sequence of `seed`, stretched over the light; on
// a line along its edge, of a point the
// one that there is. Never a plain grid: edges parallel to the light's would alias with
// it.
std::vector<glm::dvec2> SobolLightPoints(const AreaLight& light, int k, uint32_t seed);

}  // namespace halfshade
