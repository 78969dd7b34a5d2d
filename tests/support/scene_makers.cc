#include "tests/support/scene_makers.h"

#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

namespace halfshade {
namespace {

constexpr double kGoldenAngle = 2.399963229728653;

glm::vec4 Gray(float value) { return {value, value, value, 1}; }

// A grid of (columns + 1) x (rows + 1) points, given by a function of (s, t) in [0,1]^2, with smooth normals by differences.
template <typename Surface>
void AddGrid(GlbMesh& mesh, int columns, int rows, Surface surface) {
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

// A surface of revolution around the vertical through `base`; `profile`: (radius, height) for t in [0,1], upward.
template <typename Profile>
void AddRevolution(GlbMesh& mesh, const glm::dvec3& base, int segments, int rows, Profile profile) {
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

// A leaf on its stem: both bend under their weight.
void AddLeaf(GlbMesh& leaves, GlbMesh& stems, double angle, double rise, double reach, double width) {
  const glm::dvec3 out(std::cos(angle), 0, std::sin(angle));
  const glm::dvec3 side(-std::sin(angle), 0, std::cos(angle));
  const glm::dvec3 root(0, 0.38, 0);
  const auto spine = [&](double t) {
    return root + out * (reach * t) + glm::dvec3(0, rise * t - 0.75 * reach * t * t * t, 0);
  };
  constexpr double kStem = 0.42;  // of the spine
  AddGrid(leaves, 8, 16, [&](double s, double t) {
    const double along = kStem + (1 - kStem) * t;
    const double outline = width * std::pow(std::sin(M_PI * std::min(1.0, std::max(0.0, 0.02 + 0.97 * t))), 0.8);
    const double across = (2 * s - 1) * outline;
    return spine(along) + side * across + glm::dvec3(0, -0.9 * across * across / width, 0);
  });
  AddGrid(stems, 8, 10, [&](double s, double t) {
    const double turn = 2 * M_PI * s;
    const double radius = 0.008 * (1.3 - t);
    return spine(kStem * 1.05 * t) + side * (radius * std::cos(turn)) + glm::dvec3(0, radius * std::sin(turn), 0);
  });
}

MadeScene MakePlant() {
  GlbMesh pot, soil, leaves, stems;
  pot.name = "pot";
  pot.base_color = {0.55f, 0.24f, 0.14f, 1};
  pot.is_double_sided = true;
  AddRevolution(pot, {0, 0, 0}, 64, 24, [](double t) {
    const double height = 0.42 * t;
    return glm::dvec2(0.2 + 0.1 * t + (t > 0.84 ? 0.025 : 0.0), height);
  });
  soil.name = "soil";
  soil.base_color = {0.09f, 0.06f, 0.045f, 1};
  AddRevolution(soil, {0, 0, 0}, 64, 2, [](double t) { return glm::dvec2(0.29 * (1 - t), 0.36 + 0.02 * t); });
  leaves.name = "leaves";
  leaves.base_color = {0.16f, 0.42f, 0.13f, 1};
  leaves.is_double_sided = true;
  stems.name = "stems";
  stems.base_color = {0.25f, 0.35f, 0.12f, 1};
  stems.is_double_sided = true;
  std::mt19937 random(11);
  const auto unit = [&random] { return double(random() >> 8) / double(1 << 24); };
  for (int i = 0; i < 26; ++i) {
    const double up = 1 - i / 26.0;
    AddLeaf(leaves, stems, kGoldenAngle * i, 0.35 + 1.15 * up + 0.1 * unit(), 0.45 + 0.35 * (1 - up) + 0.1 * unit(),
            0.085 + 0.035 * unit());
  }
  MadeScene scene;
  scene.meshes = {pot, soil, leaves, stems};
  scene.eye = {1.5, 1.55, 2.6};
  scene.target = {0.15, 0.5, 0};
  scene.light_center = {-1.7, 2.9, 1.0};
  scene.light_target = {0, 0.5, 0};
  scene.light_edge_m = 0.6;
  scene.ground_size_m = 9;
  return scene;
}

MadeScene MakeColonnade() {
  GlbMesh steps, columns, beams;
  steps.name = "steps";
  steps.base_color = Gray(0.55f);
  for (int i = 0; i < 3; ++i) {
    const double inset = 0.25 * i;
    AddBox(steps, {-4.2 + inset, 0.18 * i, -1.9 + inset}, {4.2 - inset, 0.18 * (i + 1), 1.9 - inset});
  }
  columns.name = "columns";
  columns.base_color = {0.72f, 0.68f, 0.6f, 1};
  columns.is_double_sided = true;
  beams.name = "beams";
  beams.base_color = {0.66f, 0.62f, 0.55f, 1};
  constexpr double kFloor = 0.54, kHeight = 2.9;
  for (const double z : {-0.95, 0.95}) {
    for (int i = 0; i < 6; ++i) {
      const double x = -3.2 + 1.28 * i;
      AddBox(columns, {x - 0.27, kFloor, z - 0.27}, {x + 0.27, kFloor + 0.1, z + 0.27});
      // Entasis: the shaft swells a little and narrows toward the top.
      AddRevolution(columns, {x, kFloor + 0.1, z}, 40, 16, [](double t) {
        return glm::dvec2(0.21 - 0.05 * t + 0.02 * std::sin(M_PI * t), (kHeight - 0.22) * t);
      });
      AddBox(columns, {x - 0.25, kFloor + kHeight - 0.12, z - 0.25}, {x + 0.25, kFloor + kHeight, z + 0.25});
    }
    AddBox(beams, {-3.6, kFloor + kHeight, z - 0.24}, {3.6, kFloor + kHeight + 0.35, z + 0.24});
  }
  for (int i = 0; i < 11; ++i) {
    const double x = -3.4 + 0.68 * i;
    AddBox(beams, {x - 0.07, kFloor + kHeight + 0.35, -1.45}, {x + 0.07, kFloor + kHeight + 0.5, 1.45});
  }
  MadeScene scene;
  scene.meshes = {steps, columns, beams};
  scene.eye = {5.4, 3.4, 7.6};
  scene.target = {0.2, 1.35, 0};
  scene.light_center = {-6.5, 8.5, 5.0};
  scene.light_target = {0, 1, 0};
  scene.light_edge_m = 1.3;
  scene.ground_size_m = 30;
  return scene;
}

}  // namespace

std::vector<std::string> SceneNames() { return {"plant", "colonnade"}; }

MadeScene MakeScene(const std::string& name) {
  assert(name == "plant" || name == "colonnade");
  return name == "plant" ? MakePlant() : MakeColonnade();
}

std::string ViewFileText(const MadeScene& scene, const std::string& scene_path) {
  const auto list = [](const glm::dvec3& v) { return nlohmann::ordered_json{v.x, v.y, v.z}; };
  const glm::dvec3 normal = glm::normalize(scene.light_target - scene.light_center);
  const glm::dvec3 u = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), normal));
  nlohmann::ordered_json view;
  view["scene"] = scene_path;
  view["camera"] = {{"eye", list(scene.eye)}, {"target", list(scene.target)}, {"up", {0, 1, 0}}, {"fovy_deg", scene.fovy_deg}};
  view["light"] = {{"center", list(scene.light_center)}, {"normal", list(normal)}, {"u", list(u)},
                   {"v", list(glm::cross(normal, u))}, {"width", scene.light_edge_m}, {"height", scene.light_edge_m}};
  view["ground"] = {{"y", scene.ground_height_m}, {"size", scene.ground_size_m}, {"add", true}};
  return view.dump(1) + "\n";
}

}  // namespace halfshade
