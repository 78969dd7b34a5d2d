// Vertices at one place, as one. Pure; no GL.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace halfshade {

// Of each position the first that is equal to it (-0 is 0).
std::vector<uint32_t> WeldPositions(std::span<const glm::vec3> positions);

}  // namespace halfshade
