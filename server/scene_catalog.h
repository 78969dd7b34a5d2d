// Scenes by name: manifests and blobs in the store, flat scenes in the cache. Blocks on disk and parser: call it from
// the CPU pool. Thread-safe.
#pragma once

#include <absl/status/statusor.h>

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "halfshade/v1/scene.pb.h"
#include "server/limits.h"
#include "server/scene_cache.h"
#include "server/store.h"

namespace halfshade {

class SceneCatalog {
 public:
  // Both outlive the catalog.
  SceneCatalog(Store* store, SceneCache* cache, const Limits& limits) : store_(store), cache_(cache), limits_(limits) {}

  struct Created {
    v1::Scene scene;
    bool existed = false;
  };
  // INVALID_ARGUMENT for a malformed digest or URI, a manifest over its bounds, or a scene that the loader refuses;
  // NOT_FOUND naming a blob that is not here.
  absl::StatusOr<Created> Create(const v1::CreateSceneRequest& request);

  // The scene, from the cache or loaded again from its blobs. INVALID_ARGUMENT for a malformed name, NOT_FOUND for an
  // unknown one. `load_ms`: what loading took, 0 from the cache.
  absl::StatusOr<SceneCache::ScenePtr> Load(const std::string& name, double* load_ms);

  absl::StatusOr<v1::Scene> Describe(const std::string& name);
  // Up to `count` names after `after` (exclusive), in order.
  std::vector<std::string> List(const std::string& after, size_t count) const;
  // Also removes the blobs that no other scene uses.
  absl::Status Delete(const std::string& name);

 private:
  absl::StatusOr<FlatScene> LoadFromBlobs(const std::string& root_digest,
                                          const std::map<std::string, std::string>& files);

  Store* store_;
  SceneCache* cache_;
  const Limits limits_;
  std::mutex delete_mutex_;  // a scene is not made while another one's blobs are swept
};

}  // namespace halfshade
