// Scenes by name: manifests and blobs in the store, flat scenes in the cache. Blocks on disk and parser: call it from a
// CPU pool. Thread-safe; nobody waits for another one's scene to load, but those who want the same one.
#pragma once

#include <absl/status/statusor.h>

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "halfshade/v1/render.pb.h"
#include "halfshade/v1/scene.pb.h"
#include "server/limits.h"
#include "server/scene_cache.h"
#include "server/store.h"

namespace halfshade {

class SceneCatalog {
 public:
  // Over the scenes that the store has. Both outlive the catalog. INTERNAL: a manifest cannot be read.
  static absl::StatusOr<std::unique_ptr<SceneCatalog>> Open(Store* store, SceneCache* cache, const Limits& limits);

  struct Created {
    v1::Scene scene;
    bool existed = false;
  };
  // INVALID_ARGUMENT for a malformed digest or URI, a manifest over its bounds, or a scene that the loader refuses;
  // NOT_FOUND naming a blob that is not here, or was found damaged; the cache's and the store's errors.
  absl::StatusOr<Created> Create(const v1::CreateSceneRequest& request);

  // The scene, from the cache or loaded again from its blobs. INVALID_ARGUMENT for a malformed name, NOT_FOUND for an
  // unknown one or a blob that was found damaged; the cache's errors. `load_ms`: what loading took, 0 from the cache.
  absl::StatusOr<SceneCache::ScenePtr> Load(const std::string& name, double* load_ms);

  // The scene as the request bends it: a copy of its own in the cache, under a name of its own, where the request moves
  // joints or morph targets. Also the errors of ResolveMotion, and INVALID_ARGUMENT where it bends too far.
  struct Posed {
    SceneCache::ScenePtr scene;
    std::string name;  // keys what is kept of it; begins with the scene's
  };
  absl::StatusOr<Posed> LoadPosed(const v1::RenderRequest& request, double* load_ms);

  bool Has(const std::string& name) const;  // requires a scene's name
  absl::StatusOr<v1::Scene> Describe(const std::string& name);
  // Up to `count` names after `after` (exclusive), in order.
  std::vector<std::string> List(const std::string& after, size_t count) const;
  // Also removes the scene's blobs that no other scene uses. A blob that a Create under way needs stays, and goes when
  // that fails.
  absl::Status Delete(const std::string& name);

 private:
  struct Manifest {
    std::string root_digest;
    std::map<std::string, std::string> files;  // relative URI -> digest
    std::set<std::string> Digests() const;
  };
  // Who needs a blob.
  struct Use {
    int scenes = 0;
    int creates = 0;           // under way
    bool is_unwanted = false;  // its last scene was deleted
  };
  class Pin;       // of a Create's blobs
  class NameLock;  // of a name whose manifest is written or removed

  SceneCatalog(Store* store, SceneCache* cache, const Limits& limits) : store_(store), cache_(cache), limits_(limits) {}
  absl::StatusOr<std::string> Read(StoreKind kind, const std::string& digest);
  absl::StatusOr<Manifest> ReadManifest(const std::string& name);
  absl::Status CheckBlobs(const Manifest& manifest) const;
  absl::StatusOr<FlatScene> LoadFromBlobs(const Manifest& manifest);
  absl::StatusOr<bool> Publish(const std::string& name, const Manifest& manifest);
  absl::Status RemoveUnwanted(const std::set<std::string>& digests);  // under mutex_

  Store* store_;
  SceneCache* cache_;
  const Limits limits_;
  std::mutex mutex_;  // held for short disk work, never while a scene loads
  std::condition_variable changed_;
  std::map<std::string, Use> uses_;  // by digest of a blob
  std::set<std::string> locked_names_;
};

}  // namespace halfshade
