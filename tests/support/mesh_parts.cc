#include "tests/support/mesh_parts.h"

#include <cmath>

namespace halfshade {

void AddGrid(GlbMesh& mesh, int columns, int rows, const std::function<glm::dvec3(double s, double t)>& surface) {
  const uint32_t first = uint32_t(mesh.positions.size());
  constexpr double kStep = 1e-4;
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column) {
      const double s = double(column) / columns, t = double(row) / rows;
      const glm::dvec3 ds = surface(s + kStep, t) - surface(s - kStep, t);
      const glm::dvec3 dt = surface(s, t + kStep) - surface(s, t - kStep);
      const glm::dvec3 normal = glm::cross(ds, dt);
      mesh.positions.emplace_back(surface(s, t));
      mesh.normals.emplace_back(glm::length(normal) > 0 ? glm::normalize(normal) : glm::dvec3(0, 1, 0));
    }
  }
  const uint32_t stride = uint32_t(columns) + 1;
  for (uint32_t row = 0; row < uint32_t(rows); ++row) {
    for (uint32_t column = 0; column < uint32_t(columns); ++column) {
      const uint32_t a = first + row * stride + column;
      for (const uint32_t i : {a, a + 1, a + stride + 1, a, a + stride + 1, a + stride}) mesh.indices.push_back(i);
    }
  }
}

void AddRevolution(GlbMesh& mesh, const glm::dvec3& base, int segments, int rows,
                   const std::function<glm::dvec2(double t)>& profile) {
  AddGrid(mesh, segments, rows, [&](double s, double t) {
    const glm::dvec2 p = profile(t);
    const double angle = -2 * M_PI * s;
    return base + glm::dvec3(p.x * std::cos(angle), p.y, p.x * std::sin(angle));
  });
}

void AddBox(GlbMesh& mesh, const glm::dvec3& low, const glm::dvec3& high) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool is_high : {false, true}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const uint32_t first = uint32_t(mesh.positions.size());
      for (int corner = 0; corner < 4; ++corner) {
        glm::dvec3 p = low;
        p[axis] = is_high ? high[axis] : low[axis];
        p[u] = (corner == 1 || corner == 2) ? high[u] : low[u];
        p[v] = corner >= 2 ? high[v] : low[v];
        glm::dvec3 normal(0);
        normal[axis] = is_high ? 1 : -1;
        mesh.positions.emplace_back(p);
        mesh.normals.emplace_back(normal);
      }
      const uint32_t order[2][6] = {{0, 2, 1, 0, 3, 2}, {0, 1, 2, 0, 2, 3}};
      for (const uint32_t i : order[is_high ? 1 : 0]) mesh.indices.push_back(first + i);
    }
  }
}

void AddTurnedBox(GlbMesh& mesh, const glm::dvec3& low, const glm::dvec3& high, double turn_rad, int cells) {
  const glm::dvec3 middle = (low + high) * 0.5;
  const double cosine = std::cos(turn_rad), sine = std::sin(turn_rad);
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool is_high : {false, true}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      AddGrid(mesh, cells, cells, [&](double s, double t) {
        if (!is_high) std::swap(s, t);  // so that the grid faces outward
        glm::dvec3 p = is_high ? high : low;
        p[u] = (1 - s) * low[u] + s * high[u];
        p[v] = (1 - t) * low[v] + t * high[v];
        p -= middle;
        return middle + glm::dvec3(cosine * p.x + sine * p.z, p.y, cosine * p.z - sine * p.x);
      });
    }
  }
}

void AddStarSolid(GlbMesh& mesh, const glm::dvec3& center, int rings,
                  const std::function<double(const glm::dvec3& direction)>& radius) {
  const uint32_t first = uint32_t(mesh.positions.size());
  const uint32_t first_index = uint32_t(mesh.indices.size());
  const uint32_t segments = 2 * uint32_t(rings);
  const auto add_point = [&](double polar, double around) {
    const glm::dvec3 direction(std::sin(polar) * std::cos(around), std::cos(polar),
                               -std::sin(polar) * std::sin(around));
    mesh.positions.emplace_back(center + direction * radius(direction));
  };
  for (int ring = 1; ring < rings; ++ring) {
    for (uint32_t segment = 0; segment < segments; ++segment) {
      add_point(M_PI * ring / rings, 2 * M_PI * segment / segments);
    }
  }
  const uint32_t top = uint32_t(mesh.positions.size());
  add_point(0, 0);
  add_point(M_PI, 0);
  const uint32_t last_ring = first + uint32_t(rings - 2) * segments;
  for (uint32_t a = 0; a < segments; ++a) {
    const uint32_t b = (a + 1) % segments;
    for (const uint32_t i : {top, first + a, first + b, top + 1, last_ring + b, last_ring + a})
      mesh.indices.push_back(i);
    for (uint32_t ring = first; ring < last_ring; ring += segments) {
      const uint32_t below = ring + segments;
      for (const uint32_t i : {ring + a, below + a, ring + b, ring + b, below + a, below + b})
        mesh.indices.push_back(i);
    }
  }
  std::vector<glm::dvec3> normals(mesh.positions.size() - first, glm::dvec3(0));  // weighted by area
  for (size_t i = first_index; i < mesh.indices.size(); i += 3) {
    const glm::dvec3 a(mesh.positions[mesh.indices[i]]), b(mesh.positions[mesh.indices[i + 1]]),
        c(mesh.positions[mesh.indices[i + 2]]);
    for (size_t corner = 0; corner < 3; ++corner) {
      normals[mesh.indices[i + corner] - first] += glm::cross(b - a, c - a);
    }
  }
  for (const glm::dvec3& normal : normals) mesh.normals.emplace_back(glm::normalize(normal));
}

}  // namespace halfshade
