#include "server/scene_catalog.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdint>

#include "renderer/scene/deform.h"
#include "renderer/scene/pose.h"
#include "renderer/scene_loader/scene_loader.h"
#include "renderer/status.h"
#include "server/digest.h"
#include "server/light_data_store.h"
#include "server/scene_name.h"
#include "server/validate.h"

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
  summary.set_animations(uint32_t(scene.animations.size()));
  for (const Node& node : scene.nodes) summary.add_node_names(node.name);
  for (const std::string& warning : scene.warnings) summary.add_warnings(warning);
  summary.set_size_bytes(scene.SizeBytes());
  summary.set_gltf_scenes(uint32_t(scene.scenes.size()));
  return summary;
}

}  // namespace

// While it lives, Delete leaves these blobs alone.
class SceneCatalog::Pin {
 public:
  Pin(SceneCatalog* catalog, std::set<std::string> digests) : catalog_(catalog), digests_(std::move(digests)) {
    const std::lock_guard lock(catalog_->mutex_);
    for (const std::string& digest : digests_) ++catalog_->uses_[digest].creates;
  }
  ~Pin() {
    const std::lock_guard lock(catalog_->mutex_);
    for (const std::string& digest : digests_) --catalog_->uses_[digest].creates;
    if (const absl::Status status = catalog_->RemoveUnwanted(digests_); !status.ok()) {
      spdlog::error("blobs of a deleted scene: {}", status.ToString());
    }
  }
  Pin(const Pin&) = delete;
  Pin& operator=(const Pin&) = delete;

 private:
  SceneCatalog* catalog_;
  const std::set<std::string> digests_;
};

class SceneCatalog::NameLock {
 public:
  NameLock(SceneCatalog* catalog, const std::string& name) : catalog_(catalog), name_(name) {
    std::unique_lock lock(catalog_->mutex_);
    catalog_->changed_.wait(lock, [this] { return catalog_->locked_names_.insert(name_).second; });
  }
  ~NameLock() {
    {
      const std::lock_guard lock(catalog_->mutex_);
      catalog_->locked_names_.erase(name_);
    }
    catalog_->changed_.notify_all();
  }
  NameLock(const NameLock&) = delete;
  NameLock& operator=(const NameLock&) = delete;

 private:
  SceneCatalog* catalog_;
  const std::string name_;
};

std::set<std::string> SceneCatalog::Manifest::Digests() const {
  std::set<std::string> digests = {root_digest};
  for (const auto& [uri, digest] : files) digests.insert(digest);
  return digests;
}

absl::StatusOr<std::unique_ptr<SceneCatalog>> SceneCatalog::Open(Store* store, SceneCache* cache,
                                                                 const Limits& limits) {
  auto catalog = std::unique_ptr<SceneCatalog>(new SceneCatalog(store, cache, limits));
  for (const std::string& name : catalog->List("", SIZE_MAX)) {
    const absl::StatusOr<Manifest> manifest = catalog->ReadManifest(name);
    if (absl::IsNotFound(manifest.status())) {
      spdlog::warn("{}", manifest.status().ToString());
      continue;
    }
    // Not knowing who uses a blob, Delete could take it from another scene.
    RETURN_IF_ERROR(manifest.status());
    for (const std::string& digest : manifest->Digests()) ++catalog->uses_[digest].scenes;
  }
  return catalog;
}

// What is damaged is not here: the caller uploads it again.
absl::StatusOr<std::string> SceneCatalog::Read(StoreKind kind, const std::string& digest) {
  absl::StatusOr<std::string> bytes = store_->Get(kind, digest);
  if (absl::IsDataLoss(bytes.status())) return absl::NotFoundError(bytes.status().message());
  return bytes;
}

absl::StatusOr<SceneCatalog::Manifest> SceneCatalog::ReadManifest(const std::string& name) {
  ASSIGN_OR_RETURN(const std::string text, Read(StoreKind::kScene, DigestOf(name)));
  Manifest manifest;
  if (!ParseSceneManifest(text, &manifest.root_digest, &manifest.files)) {
    return absl::NotFoundError(name + " is no scene; create it");
  }
  return manifest;
}

// Before the first byte is read: what is missing, and what is too large to be held in memory.
absl::Status SceneCatalog::CheckBlobs(const Manifest& manifest) const {
  for (const std::string& digest : manifest.Digests()) {
    if (!store_->Has(StoreKind::kBlob, digest)) return absl::NotFoundError(digest + " is not here; upload it");
  }
  uint64_t bytes = store_->SizeOf(StoreKind::kBlob, manifest.root_digest);
  for (const auto& [uri, digest] : manifest.files) bytes += store_->SizeOf(StoreKind::kBlob, digest);
  if (bytes <= limits_.scene_bytes) return absl::OkStatus();
  return absl::InvalidArgumentError("/: " + std::to_string(bytes) + " bytes with all files; at most " +
                                    std::to_string(limits_.scene_bytes));
}

absl::StatusOr<FlatScene> SceneCatalog::LoadFromBlobs(const Manifest& manifest) {
  RETURN_IF_ERROR(CheckBlobs(manifest));
  ASSIGN_OR_RETURN(const std::string root, Read(StoreKind::kBlob, manifest.root_digest));
  std::map<std::string, std::string> bytes;  // by digest: two URIs may name one blob
  FileMap file_map;
  for (const auto& [uri, digest] : manifest.files) {
    const auto [blob, is_new] = bytes.try_emplace(digest);
    if (is_new) {
      ASSIGN_OR_RETURN(blob->second, Read(StoreKind::kBlob, digest));
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
  const Manifest manifest = {request.root_digest(), {request.files().begin(), request.files().end()}};
  const std::string name = SceneName(manifest.root_digest, manifest.files);
  const auto load = [&] { return LoadFromBlobs(manifest); };
  const Pin pin(this, manifest.Digests());
  // The cache may have a scene whose blobs are gone.
  RETURN_IF_ERROR(CheckBlobs(manifest));
  Created created;
  if (request.validate_only() && !Has(name)) {
    ASSIGN_OR_RETURN(const FlatScene scene, load());
    created.scene = Summarise(name, scene);
    return created;
  }
  ASSIGN_OR_RETURN(const SceneCache::ScenePtr scene, cache_->Get(name, load));
  ASSIGN_OR_RETURN(created.existed, Publish(name, manifest));
  created.scene = Summarise(name, *scene);
  return created;
}

// Whether it was there.
absl::StatusOr<bool> SceneCatalog::Publish(const std::string& name, const Manifest& manifest) {
  const NameLock name_lock(this, name);
  if (Has(name)) return true;
  RETURN_IF_ERROR(store_->Put(StoreKind::kScene, DigestOf(name), SceneManifest(manifest.root_digest, manifest.files)));
  const std::lock_guard lock(mutex_);
  for (const std::string& digest : manifest.Digests()) {
    Use& use = uses_[digest];
    ++use.scenes;
    use.is_unwanted = false;
  }
  return false;
}

absl::StatusOr<SceneCache::ScenePtr> SceneCatalog::Load(const std::string& name, double* load_ms) {
  RETURN_IF_ERROR(CheckName(name));
  *load_ms = 0;
  if (!Has(name)) return absl::NotFoundError(name + " is not here; create it");
  return cache_->Get(name, [&]() -> absl::StatusOr<FlatScene> {
    const auto begin = std::chrono::steady_clock::now();
    ASSIGN_OR_RETURN(const Manifest manifest, ReadManifest(name));
    ASSIGN_OR_RETURN(FlatScene scene, LoadFromBlobs(manifest));
    *load_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return scene;
  });
}

absl::StatusOr<SceneCatalog::Posed> SceneCatalog::LoadPosed(const v1::RenderRequest& request, double* load_ms) {
  ASSIGN_OR_RETURN(const SceneCache::ScenePtr scene, Load(request.scene(), load_ms));
  if (scene->deformed.empty()) return Posed{scene, request.scene()};
  ASSIGN_OR_RETURN(const Motion motion, ResolveMotion(request, *scene));
  const std::vector<bool> bends = BendingNodes(*scene);
  std::vector<NodeOverride> joints;
  for (const NodeOverride& change : motion.overrides) {
    if (change.local && bends[change.node]) joints.push_back(change);
  }
  if (joints.empty() && motion.morph_weights == scene->morph_weights) return Posed{scene, request.scene()};
  Sha256 sha;
  for (const NodeOverride& change : joints) {
    sha.Add(&change.node, sizeof(change.node));
    sha.Add(&*change.local, sizeof(*change.local));
  }
  sha.Add(motion.morph_weights.data(), motion.morph_weights.size() * sizeof(float));
  const std::string name = request.scene() + kPoseSeparator + sha.FinishHex();
  ASSIGN_OR_RETURN(const SceneCache::ScenePtr posed, cache_->Get(name, [&]() -> absl::StatusOr<FlatScene> {
    const auto begin = std::chrono::steady_clock::now();
    FlatScene copy = *scene;
    RETURN_IF_ERROR(Deform(joints, motion.morph_weights, &copy));
    ForgetBinding(&copy);
    *load_ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return copy;
  }));
  return Posed{posed, name};
}

bool SceneCatalog::Has(const std::string& name) const { return store_->Has(StoreKind::kScene, DigestOf(name)); }

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
  const NameLock name_lock(this, name);
  ASSIGN_OR_RETURN(const Manifest manifest, ReadManifest(name));
  RETURN_IF_ERROR(store_->Remove(StoreKind::kScene, {DigestOf(name)}));
  cache_->Forget(name);
  RETURN_IF_ERROR(RemoveLightData(store_, name));
  const std::lock_guard lock(mutex_);
  const std::set<std::string> digests = manifest.Digests();
  for (const std::string& digest : digests) {
    Use& use = uses_[digest];
    use.is_unwanted = --use.scenes == 0;
  }
  return RemoveUnwanted(digests);
}

// Of these blobs those that a deleted scene left and nobody needs.
absl::Status SceneCatalog::RemoveUnwanted(const std::set<std::string>& digests) {
  std::vector<std::string> unwanted;
  for (const std::string& digest : digests) {
    const Use use = uses_[digest];
    if (use.scenes > 0 || use.creates > 0) continue;
    if (use.is_unwanted) unwanted.push_back(digest);
    uses_.erase(digest);
  }
  return unwanted.empty() ? absl::OkStatus() : store_->Remove(StoreKind::kBlob, unwanted);
}

}  // namespace halfshade
