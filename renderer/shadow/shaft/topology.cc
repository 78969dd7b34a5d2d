#include "renderer/shadow/shaft/topology.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "renderer/scene/weld.h"

namespace halfshade {
namespace {

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
  std::vector<uint32_t> welded = WeldPositions(positions);
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
  topology.welded = std::move(welded);
  return topology;
}

}  // namespace halfshade
