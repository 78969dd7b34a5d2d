// A request that is accepted and a scene that suits it, for the tests of server/validate.
#pragma once

#include <string>

#include "halfshade/v1/render.pb.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

inline const std::string kScene = "scenes/" + std::string(64, 'a');

inline v1::RenderRequest Good() {
  v1::RenderRequest request;
  request.set_scene(kScene);
  v1::LookAt* look_at = request.mutable_camera()->mutable_look_at();
  look_at->mutable_eye()->set_z(5);
  look_at->mutable_target();
  v1::AreaLight* light = request.add_lights();
  light->mutable_center()->set_y(3);
  light->mutable_edge_u()->set_x(1);
  light->mutable_edge_v()->set_z(1);  // cross(u, v) = -y
  return request;
}

// A unit cube's bounds and one perspective camera at (0, 0, 4).
inline FlatScene Scene() {
  FlatScene scene;
  scene.positions = {{-1, -1, -1}, {1, 1, 1}, {1, -1, 0}};
  scene.normals.assign(3, glm::vec3(0));
  scene.texcoords.assign(3, glm::vec2(0));
  scene.indices = {0, 1, 2};
  Mesh mesh;
  mesh.vertex_count = mesh.index_count = 3;
  for (const glm::vec3& p : scene.positions) mesh.bounds.Add(p);
  scene.meshes = {mesh};
  scene.materials.resize(1);
  Node body, eye;
  body.mesh_count = 1;
  eye.camera = 0;
  eye.local[3] = glm::dvec4(0, 0, 4, 1);
  scene.nodes = {body, eye};
  SceneCamera camera;
  camera.fovy_rad = 1;
  camera.near_m = 0.1;
  scene.cameras = {camera};
  scene.scenes = {{"", {0, 1}}};
  return scene;
}

inline void Certify(v1::RenderRequest& request, uint32_t pixels, uint32_t rays) {
  request.mutable_certify()->set_pixels(pixels);
  request.mutable_certify()->set_rays(rays);
}

inline v1::LookAt& LookAt(v1::RenderRequest& request) { return *request.mutable_camera()->mutable_look_at(); }
inline v1::AreaLight& Light(v1::RenderRequest& request) { return *request.mutable_lights(0); }

}  // namespace halfshade
