#include "renderer/warm_up.h"

#include <cmath>

#include "renderer/status.h"

namespace halfshade {
namespace {

// One triangle in the plane z = 0.
FlatScene Triangle() {
  FlatScene scene;
  scene.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  scene.normals.assign(3, {0, 0, 1});
  scene.texcoords.assign(3, {0, 0});
  scene.indices = {0, 1, 2};
  Mesh mesh;
  mesh.vertex_count = mesh.index_count = 3;
  mesh.cluster_count = 1;
  for (const glm::vec3& p : scene.positions) mesh.bounds.Add(p);
  scene.meshes = {mesh};
  scene.clusters = {{0, 1, mesh.bounds}};
  scene.materials.resize(1);
  Node node;
  node.mesh_count = 1;
  scene.nodes = {node};
  scene.scenes = {{"", {0}}};
  return scene;
}

}  // namespace

absl::Status WarmUp(Renderer& renderer) {
  const std::string name = "warm-up";
  const FlatScene scene = Triangle();
  RenderRequest request;
  request.camera.eye_ws = {0, 0, 3};
  request.width = request.height = 16;
  request.ground = Ground{-1, 10, false};
  AreaLight light;
  light.center_ws = {0, 1, 2};
  light.axis_u_ws = {-1, 0, 0};
  light.axis_v_ws = glm::dvec3(0, 1, -2) / std::sqrt(5.0);
  light.normal_ws = glm::cross(light.axis_u_ws, light.axis_v_ws);
  if (light.normal_ws.z > 0) {
    light.axis_u_ws = -light.axis_u_ws;
    light.normal_ws = -light.normal_ws;
  }
  light.width_m = light.height_m = 0.5;
  light.radiance = light.intensity = glm::vec3(1);
  request.lights = {light};
  for (const MethodOptions& method : {MethodOptions(HardOptions{16}), MethodOptions(MultiMapOptions{2, 16})}) {
    for (const OutputKind kind : {OutputKind::kFrame, OutputKind::kVisibility}) {
      request.method = method;
      request.outputs = {kind};
      RETURN_IF_ERROR(renderer.Render(name, scene, request, [] { return absl::OkStatus(); }).status());
    }
  }
  request.outputs = {OutputKind::kFrame, OutputKind::kObjectId};
  request.ground->is_shadow_catcher = true;
  RETURN_IF_ERROR(renderer.Render(name, scene, request, [] { return absl::OkStatus(); }).status());
  return absl::OkStatus();
}

}  // namespace halfshade
