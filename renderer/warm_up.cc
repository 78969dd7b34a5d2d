#include "renderer/warm_up.h"

#include <cmath>

#include "renderer/status.h"

namespace halfshade {
namespace {

// A triangle in the plane z = 0 for each program of the G-buffer that real scenes take: without textures, with a base
// colour, with maps too, and masked; and one that is BLEND, for light.
FlatScene Triangles() {
  constexpr uint32_t kMaterials = 5;
  FlatScene scene;
  scene.images = {{"warm-up", "", 1, 1}};
  scene.textures.resize(1);
  scene.materials.resize(kMaterials + 1);
  for (uint32_t i = 1; i < kMaterials; ++i) scene.materials[i].base_color_texture.texture = 0;
  scene.materials[2].normal_texture.texture = 0;
  scene.materials[3].alpha_mode = AlphaMode::kMask;
  scene.materials[4].alpha_mode = AlphaMode::kBlend;
  SceneRoots roots;
  for (uint32_t i = 0; i < kMaterials; ++i) {
    Mesh mesh;
    mesh.first_vertex = mesh.first_index = 3 * i;
    mesh.vertex_count = mesh.index_count = 3;
    mesh.first_cluster = i;
    mesh.cluster_count = 1;
    mesh.material = i;
    for (const glm::vec3& p : {glm::vec3(-1, -1, 0), glm::vec3(1, -1, 0), glm::vec3(0, 1, 0)}) {
      scene.positions.push_back(p);
      scene.indices.push_back(uint32_t(scene.positions.size()) - 1 - mesh.first_vertex);
      mesh.bounds.Add(p);
    }
    scene.meshes.push_back(mesh);
    scene.clusters.push_back({0, 1, mesh.bounds});
    Node node;
    node.first_mesh = i;
    node.mesh_count = 1;
    scene.nodes.push_back(node);
    roots.roots.push_back(i);
  }
  scene.normals.assign(scene.positions.size(), {0, 0, 1});
  scene.texcoords.assign(scene.positions.size(), {0, 0});
  scene.scenes = {roots};
  return scene;
}

RenderRequest SmallRequest() {
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
  return request;
}

}  // namespace

absl::StatusOr<Rgba8Image> WarmUpTexel(const EncodedImage&) { return Rgba8Image{1, 1, {255, 255, 255, 255}}; }

absl::StatusOr<Image> DrawCanary(Renderer& renderer) {
  const std::string name = "canary";
  // Without its textures, which a canary in use could not decode.
  FlatScene scene = Triangles();
  scene.materials.assign(scene.materials.size(), {});
  RenderRequest request = SmallRequest();
  request.method = HardOptions{16};
  request.outputs = {OutputKind::kVisibility};
  request.cache = CacheMode::kRefresh;
  absl::StatusOr<RenderResult> result = renderer.Render(name, scene, request, [] { return absl::OkStatus(); });
  renderer.ForgetScene(name);
  RETURN_IF_ERROR(result.status());
  return std::move(result->images[0].image);
}

absl::Status WarmUp(Renderer& renderer) {
  const std::string name = "warm-up";
  const FlatScene scene = Triangles();
  RenderRequest request = SmallRequest();
  for (const MethodOptions& method :
       {MethodOptions(HardOptions{16}), MethodOptions(MultiMapOptions{2, 16}), MethodOptions(PcssOptions{16, 1, 1}),
        MethodOptions(SsmOptions{.occluder_map_size = 16, .sub_lights = 1}),
        MethodOptions(SsmOptions{.occluder_map_size = 16,
        .sub_lights = 1,
        .accumulation = SsmAccumulation::kScatter,
        .blend = SsmBlend::kFp16Batched,
        .projects_map = true}),

        MethodOptions(PdsmOptions{4, 16, 16, 0.2f, PdsmConstruction::kScatter, PdsmLayout::kIndexed}),
        MethodOptions(PdsmOptions{4, 16, 16, 0.2f, PdsmConstruction::kSlices, PdsmLayout::kVolume}),

        MethodOptions(SssmOptions{16, 1, 21, FilterWeights::kMean, false})}) {
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
