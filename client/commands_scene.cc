// halfshade upload, scenes, scene
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include "client/session.h"
#include "renderer/status.h"
#include "server/scene_name.h"

namespace halfshade {
namespace {

std::string ToText(const v1::Vec3& vector) { return absl::StrFormat("%g %g %g", vector.x(), vector.y(), vector.z()); }

std::string ToText(const v1::Scene& scene) {
  return absl::StrCat("name        ", scene.name(), "\nbounds      ", ToText(scene.bounds_min()), " to ",
                      ToText(scene.bounds_max()), " m\ntriangles   ", scene.triangles(), "\nmaterials   ",
                      scene.materials(), "\nscenes      ", scene.gltf_scenes(), "\nanimations  ", scene.animations(),
                      "\ncameras     ", absl::StrJoin(scene.cameras(), ", "), "\nnodes       ",
                      absl::StrJoin(scene.node_names(), ", "), "\nbytes       ", scene.size_bytes(), "\n",
                      scene.warnings_size() > 0 ? "warnings    " : "",
                      absl::StrJoin(scene.warnings(), "\n            "), scene.warnings_size() > 0 ? "\n" : "");
}

}  // namespace

absl::Status RunUpload(const GlobalFlags& global, const std::string& file) {
  ASSIGN_OR_RETURN(const SceneFiles files, ReadSceneFiles(file));
  ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(global));
  ASSIGN_OR_RETURN(const v1::Scene scene, session->client().UploadScene(files));
  if (global.servers.empty()) session->progress().Say("checked, and kept nowhere: no --server was given");
  return Print(global.wants_json ? ToJson(scene, /*with_defaults=*/true) : scene.name() + "\n");
}

absl::Status RunScenes(const GlobalFlags& global) {
  ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(global));
  v1::ListScenesResponse all;
  for (const std::string& server : session->client().servers()) {
    ASSIGN_OR_RETURN(const std::vector<v1::Scene> scenes, session->client().ListScenes(server));
    for (const v1::Scene& scene : scenes) *all.add_scenes() = scene;
  }
  if (global.wants_json) return Print(ToJson(all, /*with_defaults=*/true));
  std::string text;
  for (const v1::Scene& scene : all.scenes())
    absl::StrAppend(&text, scene.name(), "\t", scene.triangles(), " triangles\n");
  return Print(text);
}

absl::Status RunScene(const GlobalFlags& global, const std::string& scene) {
  const bool is_file = !IsSceneName(scene);
  SceneFiles files;
  if (is_file) {
    ASSIGN_OR_RETURN(files, ReadSceneFiles(scene));
  }
  ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(global));
  ASSIGN_OR_RETURN(const v1::Scene found,
                   is_file ? session->client().UploadScene(files) : session->client().GetScene(scene));
  return Print(global.wants_json ? ToJson(found, /*with_defaults=*/true) : ToText(found));
}

}  // namespace halfshade
