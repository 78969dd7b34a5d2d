#include "server/scene_catalog.h"

#include <chrono>
#include <set>

#include "renderer/scene/pose.h"
#include "renderer/scene_loader/scene_loader.h"
#include "renderer/status.h"
#include "server/scene_name.h"

namespace halfshade {
namespace {

constexpr size_t kMaxFiles = 4096;
constexpr size_t kMaxUriBytes = 1024;

std::string DigestOf(const std::string& scene_name) { return scene_name.substr(scene_name.find('/') + 1); }

absl::Status CheckName(const std::string& name) {
  if (IsSceneName(name)) return absl::OkStatus();
  return absl::InvalidArgumentError("name: \"" + name.substr(0, 80) + "\"; must be scenes/ and 64 hex digits");
}

absl::Status CheckDigest(const std::string& field, const std::string& digest) {
  if (IsSha256Hex(digest)) return absl::OkStatus();
  return absl::InvalidArgumentError(field + ": \"" + digest.substr(0, 80) + "\"; must be 64 lower-case hex digits");
}

absl::Status CheckRequest(const v1::CreateSceneRequest& request) {
  RETURN_IF_ERROR(CheckDigest("root_digest", request.root_digest()));
  if (request.files_size() > int(kMaxFiles)) {
    return absl::InvalidArgumentError("files: " + std::to_string(request.files_size()) + "; at most " +
                                      std::to_string(kMaxFiles));
  }
  for (const auto& [uri, digest] : request.files()) {
    if (uri.empty() || uri.size() > kMaxUriBytes || uri.find('\n') != std::string::npos) {
      return absl::InvalidArgumentError("files: a URI of " + std::to_string(uri.size()) +
                                        " bytes; must be 1 to 1024 without a line break");
    }
    RETURN_IF_ERROR(CheckDigest("files[\"" + uri + "\"]", digest));
  }
  return absl::OkStatus();
}

void SetVec3(const glm::dvec3& value, v1::Vec3* out) {
  out->set_x(value.x);
  out->set_y(value.y);
  out->set_z(value.z);
}

v1::Scene Summarise(const std::string& name, const FlatScene& scene) {
  v1::Scene summary;
  summary.set_name(name);
  if (const auto pose = BuildPose(scene, scene.default_scene); pose.ok()) {
    const Box3d& bounds = pose->bounds_ws;
    SetVec3(bounds.IsEmpty() ? glm::dvec3(0) : bounds.min, summary.mutable_bounds_min());
    SetVec3(bounds.IsEmpty() ? glm::dvec3(0) : bounds.max, summary.mutable_bounds_max());
    uint64_t triangles = 0;
    for (const Instance& instance : pose->instances) triangles += scene.meshes[instance.mesh].TriangleCount();
    summary.set_triangles(triangles);
  }
  summary.set_materials(uint32_t(scene.materials.empty() ? 0 : scene.materials.size() - 1));
  for (const SceneCamera& camera : scene.cameras) summary.add_cameras(camera.name);
  summary.set_animations(scene.animation_count);
  for (const Node& node : scene.nodes) summary.add_node_names(node.name);
  for (const std::string& warning : scene.warnings) summary.add_warnings(warning);
  summary.set_size_bytes(scene.SizeBytes());
  summary.set_gltf_scenes(uint32_t(scene.scenes.size()));
  return summary;
}

}  // namespace

absl::StatusOr<FlatScene> SceneCatalog::LoadFromBlobs(const std::string& root_digest,
                                                      const std::map<std::string, std::string>& files) {
  ASSIGN_OR_RETURN(const std::string root, store_->Get(StoreKind::kBlob, root_digest));
  std::map<std::string, std::string> bytes;  // by digest: two URIs may name one blob
  FileMap file_map;
  for (const auto& [uri, digest] : files) {
    const auto [blob, is_new] = bytes.try_emplace(digest);
    if (is_new) {
      ASSIGN_OR_RETURN(blob->second, store_->Get(StoreKind::kBlob, digest));
    }
    file_map[uri] = &blob->second;
  }
  SceneLoadLimits limits;
  limits.max_scene_bytes = limits_.scene_bytes;
  limits.max_triangles = limits_.scene_triangles;
  limits.max_json_bytes = limits_.gltf_json_bytes;
  limits.max_json_depth = limits_.gltf_json_depth;
  limits.max_texture_pixels = limits_.texture_pixels;
  return LoadGltf(root, file_map, limits);
}

absl::StatusOr<SceneCatalog::Created> SceneCatalog::Create(const v1::CreateSceneRequest& request) {
  RETURN_IF_ERROR(CheckRequest(request));
  const std::map<std::string, std::string> files(request.files().begin(), request.files().end());
  const std::string name = SceneName(request.root_digest(), files);
  const auto load = [&] { return LoadFromBlobs(request.root_digest(), files); };
  Created created;
  const std::lock_guard lock(delete_mutex_);
  created.existed = store_->Has(StoreKind::kScene, DigestOf(name));
  if (request.validate_only() && !created.existed) {
    ASSIGN_OR_RETURN(const FlatScene scene, load());
    created.scene = Summarise(name, scene);
    return created;
  }
  ASSIGN_OR_RETURN(const SceneCache::ScenePtr scene, cache_->Get(name, load));
  if (!created.existed) {
    RETURN_IF_ERROR(store_->Put(StoreKind::kScene, DigestOf(name), SceneManifest(request.root_digest(), files)));
  }
  created.scene = Summarise(name, *scene);
  return created;
}

absl::StatusOr<SceneCache::ScenePtr> SceneCatalog::Load(const std::string& name, double* load_ms) {
  RETURN_IF_ERROR(CheckName(name));
  *load_ms = 0;
  if (!store_->Has(StoreKind::kScene, DigestOf(name))) return absl::NotFoundError(name + " is not here; create it");
  return cache_->Get(name, [&]() -> absl::StatusOr<FlatScene> {
    const auto begin = std::chrono::steady_clock::now();
    ASSIGN_OR_RETURN(const std::string manifest, store_->Get(StoreKind::kScene, DigestOf(name)));
    std::string root_digest;
    std::map<std::string, std::string> files;
    ParseSceneManifest(manifest, &root_digest, &files);
    ASSIGN_OR_RETURN(FlatScene scene, LoadFromBlobs(root_digest, files));
    *load_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return scene;
  });
}

absl::StatusOr<v1::Scene> SceneCatalog::Describe(const std::string& name) {
  double load_ms = 0;
  ASSIGN_OR_RETURN(const SceneCache::ScenePtr scene, Load(name, &load_ms));
  return Summarise(name, *scene);
}

std::vector<std::string> SceneCatalog::List(const std::string& after, size_t count) const {
  std::vector<std::string> names;
  for (const std::string& digest : store_->List(StoreKind::kScene)) {
    const std::string name = "scenes/" + digest;
    if (name > after && names.size() < count) names.push_back(name);
  }
  return names;
}

absl::Status SceneCatalog::Delete(const std::string& name) {
  RETURN_IF_ERROR(CheckName(name));
  const std::lock_guard lock(delete_mutex_);
  ASSIGN_OR_RETURN(const std::string manifest, store_->Get(StoreKind::kScene, DigestOf(name)));
  store_->Remove(StoreKind::kScene, DigestOf(name));
  cache_->Forget(name);
  const auto digests_of = [](const std::string& text) {
    std::string root;
    std::map<std::string, std::string> files;
    ParseSceneManifest(text, &root, &files);
    std::set<std::string> digests = {root};
    for (const auto& [uri, digest] : files) digests.insert(digest);
    return digests;
  };
  std::set<std::string> unused = digests_of(manifest);
  for (const std::string& other : store_->List(StoreKind::kScene)) {
    ASSIGN_OR_RETURN(const std::string text, store_->Get(StoreKind::kScene, other));
    for (const std::string& digest : digests_of(text)) unused.erase(digest);
  }
  for (const std::string& digest : unused) store_->Remove(StoreKind::kBlob, digest);
  return absl::OkStatus();
}

}  // namespace halfshade
