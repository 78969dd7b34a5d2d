#include "tests/support/scene_classes.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "tests/support/mesh_parts.h"

namespace halfshade {
namespace {

// The same numbers on every machine, unlike the distributions of the standard library.
class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed) {}
  double Between(double low, double high) { return low + (high - low) * double(engine_() >> 8) / double(1 << 24); }
  glm::dvec3 Direction() {
    const double height = Between(-1, 1);
    const double around = Between(0, 2 * M_PI);
    const double out = std::sqrt(1 - height * height);
    return {out * std::cos(around), height, out * std::sin(around)};
  }

 private:
  std::mt19937 engine_;
};

// Edge of a square grid of `share` of the triangles, two a cell.
int Cells(uint32_t triangles, int grids) { return std::max(1, int(std::lround(std::sqrt(triangles / 2.0 / grids)))); }

// Rings of a star solid: 4 rings (rings - 1) triangles.
int Rings(double triangles) { return std::max(3, int(std::lround(0.5 + std::sqrt(0.25 + triangles / 4)))); }

MadeScene WithMesh(const char* name, const glm::vec4& color, bool is_double_sided) {
  MadeScene scene;
  scene.meshes.resize(1);
  scene.meshes[0].name = name;
  scene.meshes[0].base_color = color;
  scene.meshes[0].is_double_sided = is_double_sided;
  scene.eye = {2.1, 1.9, 3.1};
  scene.target = {0.1, 0.45, 0};
  scene.light_center = {-1.5, 3.2, 0.9};
  scene.light_target = {0, 0.6, 0};
  scene.light_edge_m = 0.4;
  scene.ground_size_m = 10;
  return scene;
}

MadeScene MakePlateClass(uint32_t triangles) {
  MadeScene scene = WithMesh("plate", {0.7f, 0.4f, 0.3f, 1}, true);
  const int cells = Cells(triangles == 0 ? 2 : triangles, 1);
  AddGrid(scene.meshes[0], cells, cells,
          [](double s, double t) { return glm::dvec3(0.8 * (s - 0.5), 1, 0.8 * (0.5 - t)); });
  scene.light_center = {0, 2, 0};
  scene.light_target = {0, 0, 0};
  return scene;
}

MadeScene MakeSmoothSolid(uint32_t triangles) {
  MadeScene scene = WithMesh("solid", {0.35f, 0.5f, 0.7f, 1}, false);
  AddStarSolid(scene.meshes[0], {0, 0.9, 0}, Rings(triangles == 0 ? 8000 : triangles),
               [](const glm::dvec3& d) { return 0.42 * (1 + 0.25 * d.x * d.y + 0.2 * d.z * d.z); });
  return scene;
}

MadeScene MakeContact(uint32_t triangles) {
  MadeScene scene = WithMesh("box", {0.7f, 0.6f, 0.4f, 1}, false);
  AddTurnedBox(scene.meshes[0], {-0.35, 0, -0.25}, {0.35, 1, 0.25}, 0.45, Cells(triangles == 0 ? 12 : triangles, 6));
  return scene;
}

MadeScene MakeTiltedSheet(uint32_t triangles) {
  MadeScene scene = WithMesh("sheet", {0.5f, 0.65f, 0.4f, 1}, true);
  const int cells = Cells(triangles == 0 ? 2 : triangles, 1);
  constexpr double kTilt = 0.7;  // radians
  AddGrid(scene.meshes[0], cells, cells, [](double s, double t) {
    const double along = 1.1 * (s - 0.5);
    return glm::dvec3(along * std::cos(kTilt), 0.6 - along * std::sin(kTilt), 0.9 * (0.5 - t));
  });
  return scene;
}

MadeScene MakeClutter(uint32_t triangles, uint32_t seed) {
  MadeScene scene = WithMesh("leaves", {0.2f, 0.45f, 0.15f, 1}, true);
  const uint32_t leaves = std::max(1u, (triangles == 0 ? 6000 : triangles) / 2);
  // As much leaf in all, however many there are.
  const double half_length = 0.045 * std::sqrt(3000.0 / leaves);
  Random random(500 + seed);
  GlbMesh& mesh = scene.meshes[0];
  for (uint32_t i = 0; i < leaves; ++i) {
    const glm::dvec3 center = glm::dvec3(0, 0.85, 0) + random.Direction() * (0.6 * std::cbrt(random.Between(0, 1)));
    const glm::dvec3 along = random.Direction();
    const glm::dvec3 other = random.Direction();
    const glm::dvec3 normal = glm::normalize(glm::cross(along, other) + 1e-9 * other);
    const glm::dvec3 across = glm::cross(normal, along) * (0.5 * half_length);
    const uint32_t first = uint32_t(mesh.positions.size());
    for (const glm::dvec3& p : {along * half_length, across, along * -half_length, -across}) {
      mesh.positions.emplace_back(center + p);
      mesh.normals.emplace_back(normal);
    }
    for (const uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + corner);
  }
  return scene;
}

// Radius of a unit ball with knobs and dents.
class Knobs {
 public:
  Knobs(int count, double height, Random& random) {
    for (int i = 0; i < count; ++i) {
      knobs_.push_back({random.Direction(), random.Between(8, 60), random.Between(-height, height)});
    }
  }
  double operator()(const glm::dvec3& direction) const {
    double radius = 1;
    for (const Knob& knob : knobs_) {
      radius += knob.height * std::exp(knob.sharpness * (glm::dot(direction, knob.direction) - 1));
    }
    return std::max(0.3, radius);
  }

 private:
  struct Knob {
    glm::dvec3 direction;
    double sharpness;
    double height;
  };
  std::vector<Knob> knobs_;
};

MadeScene MakeKnobblySolid(uint32_t triangles, uint32_t seed) {
  MadeScene scene = WithMesh("solid", {0.6f, 0.5f, 0.45f, 1}, false);
  Random random(600 + seed);
  const Knobs knobs(60, 0.35, random);
  AddStarSolid(scene.meshes[0], {0, 0.75, 0}, Rings(triangles == 0 ? 229e3 : triangles),
               [&](const glm::dvec3& d) { return 0.42 * knobs(d); });
  return scene;
}

MadeScene MakeHeap(uint32_t triangles, uint32_t seed) {
  MadeScene scene = WithMesh("stones", {0.5f, 0.48f, 0.45f, 1}, false);
  const double total = triangles == 0 ? 1e6 : triangles;
  const int stones = int(std::clamp(total / 2000, 8.0, 500.0));
  const double size = 0.95 / std::cbrt(double(stones));
  Random random(700 + seed);
  for (int i = 0; i < stones; ++i) {
    const double share = (i + 0.5) / stones;
    // Filled from the middle of the ground outward and upward: a dome.
    const glm::dvec3 direction = random.Direction();
    const double reach = 0.85 * std::cbrt(share);
    const double radius = size * random.Between(0.6, 1) * (1.25 - 0.5 * share);
    const glm::dvec3 at(direction.x * reach, std::max(1.2 * radius, std::abs(direction.y) * reach),
                        direction.z * reach);
    const Knobs knobs(10, 0.2, random);
    AddStarSolid(scene.meshes[0], at, Rings(total / stones), [&](const glm::dvec3& d) { return radius * knobs(d); });
  }
  return scene;
}

// A third of the triangles each for what stands, the ball and the vane.
MadeScene MakePergola(uint32_t triangles) {
  MadeScene scene = WithMesh("pergola", {0.55f, 0.4f, 0.28f, 1}, false);
  const double third = (triangles == 0 ? 6000 : triangles) / 3.0;
  constexpr double kSlats = 9, kBeams = 2, kPosts = 4;
  const int cells = Cells(uint32_t(third), int(6 * (kSlats + kBeams + kPosts)));
  const auto add_bar = [&](const glm::dvec3& center, const glm::dvec3& size) {
    AddTurnedBox(scene.meshes[0], center - size * 0.5, center + size * 0.5, 0, cells);
  };
  for (int i = 0; i < int(kSlats); ++i) add_bar({0.2 * (i - 4), 1.22, 0}, {0.07, 0.03, 1.4});
  for (const double z : {-0.55, 0.55}) {
    add_bar({0, 1.17, z}, {1.8, 0.06, 0.06});
    for (const double x : {-0.8, 0.8}) add_bar({x, 0.57, z}, {0.07, 1.14, 0.07});
  }

  GlbMesh ball;
  ball.name = "ball";
  ball.base_color = {0.3f, 0.45f, 0.65f, 1};
  AddStarSolid(ball, {0, 0, 0}, Rings(third), [](const glm::dvec3&) { return 0.16; });
  GlbMesh vane;
  vane.name = "vane";
  vane.base_color = {0.65f, 0.35f, 0.3f, 1};
  vane.is_double_sided = true;
  const int columns = Cells(uint32_t(third), 1);
  AddGrid(vane, columns, columns, [](double s, double t) { return glm::dvec3(0.4 * (s - 0.5), 0.5 * (t - 0.5), 0); });

  constexpr double kBallPeriod = 4, kVanePeriod = 6;  // seconds
  scene.moving.push_back({1, kBallPeriod, [=](double time_s) {
                            const double angle = 2 * M_PI * time_s / kBallPeriod;
                            return glm::translate(glm::dmat4(1), {0.45 * std::cos(angle), 0.3, 0.35 * std::sin(angle)});
                          }});
  scene.moving.push_back({2, kVanePeriod, [=](double time_s) {
                            const glm::dmat4 at = glm::translate(glm::dmat4(1), {0.0, 0.7, 0.0});
                            return glm::rotate(at, 2 * M_PI * time_s / kVanePeriod, {0.0, 1.0, 0.0});
                          }});
  for (GlbMesh* mesh : {&ball, &vane}) {
    const MovingNode& node = scene.moving[scene.meshes.size() - 1];
    mesh->world_from_mesh = node.world_from_mesh(0);
    scene.meshes.push_back(*mesh);
  }
  scene.fog = MadeFog{.density_per_m = 0.15, .albedo = {0.9, 0.9, 0.92}, .falloff_height_m = 2, .ground_m = 0};
  return scene;
}

}  // namespace

std::vector<std::string> SceneClassNames() { return {"S1", "S2", "S3", "S4", "S5", "S6", "S7", "S8"}; }

MadeScene MakeSceneClass(const std::string& name, uint32_t triangles, uint32_t seed) {
  if (name == "S1") return MakePlateClass(triangles);
  if (name == "S2") return MakeSmoothSolid(triangles);
  if (name == "S3") return MakeContact(triangles);
  if (name == "S4") return MakeTiltedSheet(triangles);
  if (name == "S5") return MakeClutter(triangles, seed);
  if (name == "S6") return MakeKnobblySolid(triangles, seed);
  if (name == "S7") return MakeHeap(triangles, seed);
  assert(name == "S8");
  return MakePergola(triangles);
}

}  // namespace halfshade
