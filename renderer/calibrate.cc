#include "renderer/calibrate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "renderer/status.h"

namespace halfshade {
namespace {

// The same on two quiet cores of an Intel Xeon with llvmpipe: the table's machine.
constexpr double kTableMs = 3;
constexpr int kRepetitions = 5;
constexpr int kSide = 32;  // quads of the sheet

// A sheet in waves, above the request's ground.
FlatScene Sheet() {
  FlatScene scene;
  Mesh mesh;
  for (int y = 0; y <= kSide; ++y) {
    for (int x = 0; x <= kSide; ++x) {
      const glm::vec3 p(float(x) / kSide - 0.5f, 0.3f * std::sin(0.7f * float(x)) * std::cos(0.6f * float(y)),
                        float(y) / kSide - 0.5f);
      scene.positions.push_back(p);
      mesh.bounds.Add(p);
    }
  }
  for (uint32_t y = 0; y < kSide; ++y) {
    for (uint32_t x = 0; x < kSide; ++x) {
      const uint32_t a = y * (kSide + 1) + x, b = a + kSide + 1;
      for (const uint32_t i : {a, b, a + 1, a + 1, b, b + 1}) scene.indices.push_back(i);
    }
  }
  scene.normals.assign(scene.positions.size(), {0, 1, 0});
  scene.texcoords.assign(scene.positions.size(), {0, 0});
  mesh.vertex_count = uint32_t(scene.positions.size());
  mesh.index_count = uint32_t(scene.indices.size());
  for (uint32_t first = 0; first < mesh.TriangleCount(); first += Cluster::kMaxTriangles) {
    scene.clusters.push_back({first, std::min(Cluster::kMaxTriangles, mesh.TriangleCount() - first), mesh.bounds});
  }
  mesh.cluster_count = uint32_t(scene.clusters.size());
  scene.materials.resize(1);
  scene.meshes = {mesh};
  Node node;
  node.mesh_count = 1;
  scene.nodes = {node};
  scene.scenes = {{"", {0}}};
  return scene;
}

}  // namespace

absl::StatusOr<double> MeasureSlowness(Renderer& renderer) {
  const std::string name = "calibration";
  const FlatScene scene = Sheet();
  RenderRequest request;
  request.camera.eye_ws = {0, 1.2, 2};
  request.camera.forward_ws = glm::normalize(glm::dvec3(0, -0.6, -1));
  request.camera.up_ws = glm::cross(request.camera.right_ws, request.camera.forward_ws);
  request.width = 192;
  request.height = 108;
  request.ground = Ground{-0.5, 3, false};
  AreaLight light;
  light.center_ws = {0.2, 2, 0.1};
  light.axis_v_ws = {0, 0, -1};
  light.normal_ws = {0, -1, 0};
  light.axis_u_ws = glm::cross(light.axis_v_ws, light.normal_ws);
  light.width_m = light.height_m = 0.4;
  light.radiance = glm::vec3(1);
  request.lights = {light};
  request.method = ShaftOptions{.rows = 16};
  request.outputs = {OutputKind::kVisibility};
  request.cache = CacheMode::kRefresh;
  double least_ms = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kRepetitions; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    RETURN_IF_ERROR(renderer.Render(name, scene, request, [] { return absl::OkStatus(); }).status());
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - begin;
    least_ms = std::min(least_ms, elapsed.count());
  }
  renderer.ForgetScene(name);
  return std::clamp(least_ms / kTableMs, 1.0 / 16, 64.0);
}

}  // namespace halfshade
