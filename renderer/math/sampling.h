// Owen-scrambled Sobol points: every power-of-two prefix is stratified in all elementary intervals, and seeds are
// independent. Source: Burley 2020, "Practical Hash-based Owen Scrambling" (nested uniform scrambling by a Laine-Karras
// style hash of reversed bits).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

namespace halfshade {

// Point `index` of the two-dimensional sequence of `seed`, in [0,1)^2, on the lattice of 2^-32.
glm::dvec2 OwenSobol2(uint32_t index, uint32_t seed);

}  // namespace halfshade
