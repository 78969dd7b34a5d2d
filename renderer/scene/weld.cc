#include "renderer/scene/weld.h"

#include <bit>
#include <cstring>

namespace halfshade {

std::vector<uint32_t> WeldPositions(std::span<const glm::vec3> positions) {
  // An open-addressing table, half empty or more.
  const size_t slots = std::bit_ceil(2 * positions.size() + 1);
  std::vector<uint32_t> table(slots, ~0u);
  std::vector<uint32_t> welded(positions.size());
  for (uint32_t i = 0; i < positions.size(); ++i) {
    const glm::vec3 p = positions[i] + 0.0f;  // -0 is 0
    uint32_t bits[3];
    std::memcpy(bits, &p.x, sizeof(bits));
    uint64_t hash = 0;
    for (const uint32_t word : bits) hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
    size_t slot = (hash >> 20) & (slots - 1);
    while (table[slot] != ~0u && positions[table[slot]] != positions[i]) slot = (slot + 1) & (slots - 1);
    if (table[slot] == ~0u) table[slot] = i;
    welded[i] = table[slot];
  }
  return welded;
}

}  // namespace halfshade
