#include "renderer/shadow/shaft/topology.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <tuple>

namespace halfshade {
namespace {

// Of each position the first that is equal to it: an open-addressing table, half empty or more.
std::vector<uint32_t> Weld(const std::vector<glm::vec3>& positions) {
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

// Disjoint sets of triangles.
class Surfaces {
 public:
  explicit Surfaces(size_t count) : parents_(count) { std::iota(parents_.begin(), parents_.end(), 0u); }
  uint32_t Of(uint32_t triangle) {
    while (parents_[triangle] != triangle) triangle = parents_[triangle] = parents_[parents_[triangle]];
    return triangle;
  }
  void Join(uint32_t a, uint32_t b) { parents_[Of(a)] = Of(b); }

 private:
  std::vector<uint32_t> parents_;
};

// One side of a triangle, kept with its vertex of the lower number.
struct Side {
  uint32_t high = 0;       // its other vertex
  uint32_t side = 0;       // 3 triangle + k
  bool is_upward = false;  // runs from the lower to the higher
};

}  // namespace

Topology FindTopology(const std::vector<glm::vec3>& positions, const std::vector<uint32_t>& indices, float least_z) {
  const auto count = uint32_t(indices.size() / 3);
  const std::vector<uint32_t> welded = Weld(positions);
  const auto corner = [&](uint32_t triangle, uint32_t k) { return welded[indices[3 * triangle + k % 3]]; };
  const auto is_degenerate = [&](uint32_t t) {
    return corner(t, 0) == corner(t, 1) || corner(t, 1) == corner(t, 2) || corner(t, 2) == corner(t, 0);
  };

  // Sides in the order of their lower vertex.
  std::vector<uint32_t> first(positions.size() + 1, 0);
  for (uint32_t t = 0; t < count; ++t) {
    if (is_degenerate(t)) continue;
    for (uint32_t k = 0; k < 3; ++k) ++first[std::min(corner(t, k), corner(t, k + 1)) + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Side> sides(first.back());
  std::vector<uint32_t> next(first.begin(), first.end() - 1);
  for (uint32_t t = 0; t < count; ++t) {
    if (is_degenerate(t)) continue;
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t a = corner(t, k), b = corner(t, k + 1);
      sides[next[std::min(a, b)]++] = {std::max(a, b), 3 * t + k, a < b};
    }
  }

  Topology topology;
  topology.neighbours.assign(indices.size(), kNoTriangle);
  Surfaces surfaces(count);
  std::vector<uint32_t> unbalanced;  // triangles at an edge that is not used as often both ways
  for (size_t vertex = 0; vertex + 1 < first.size(); ++vertex) {
    const auto begin = sides.begin() + first[vertex], end = sides.begin() + first[vertex + 1];
    std::sort(begin, end,
              [](const Side& a, const Side& b) { return std::tie(a.high, a.side) < std::tie(b.high, b.side); });
    for (auto edge = begin; edge != end;) {
      auto last = edge;
      int balance = 0;
      for (; last != end && last->high == edge->high; ++last) {
        balance += last->is_upward ? 1 : -1;
        surfaces.Join(edge->side / 3, last->side / 3);
      }
      if (balance != 0) unbalanced.push_back(edge->side / 3);
      if (balance == 0 && last - edge == 2) {
        topology.neighbours[edge[0].side] = edge[1].side / 3;
        topology.neighbours[edge[1].side] = edge[0].side / 3;
      }
      edge = last;
    }
  }

  std::vector<uint8_t> is_open(count, 0);  // of a surface, at its own triangle
  for (const uint32_t t : unbalanced) is_open[surfaces.Of(t)] = 1;
  std::vector<double> volumes(count, 0);
  for (uint32_t t = 0; t < count; ++t) {
    const uint32_t surface = surfaces.Of(t);
    glm::dvec3 p[3];
    for (uint32_t k = 0; k < 3; ++k) {
      // From a point of the surface itself, so that small solids far from the light keep their sign.
      p[k] = glm::dvec3(positions[corner(t, k)]) - glm::dvec3(positions[corner(surface, 0)]);
      if (positions[corner(t, k)].z < least_z) is_open[surface] = 1;
    }
    volumes[surface] += glm::dot(p[0], glm::cross(p[1], p[2]));
  }
  topology.closed.resize(count);
  for (uint32_t t = 0; t < count; ++t) {
    const uint32_t surface = surfaces.Of(t);
    topology.closed[t] = is_open[surface] || volumes[surface] == 0 ? 0 : volumes[surface] > 0 ? 1 : 2;
  }
  return topology;
}

}  // namespace halfshade
