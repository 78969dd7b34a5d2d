// Flat scenes in memory: least recently used go first, identical loads are done once, a scene in use stays alive under
// its user. Thread-safe.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <future>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "renderer/scene/flat_scene.h"

namespace halfshade {

class SceneCache {
 public:
  using ScenePtr = std::shared_ptr<const FlatScene>;
  using Loader = std::function<absl::StatusOr<FlatScene>()>;

  // `on_drop` is told the name of every scene that leaves the cache, under the cache's lock: it must not call back.
  explicit SceneCache(
      uint64_t max_bytes, std::function<void(const std::string& name)> on_drop = [](const std::string&) {})
      : max_bytes_(max_bytes), on_drop_(std::move(on_drop)) {}

  // The scene, loaded by `loader` if it is not here; callers that come while it loads wait for the same result. Errors
  // are the loader's and are not kept. RESOURCE_EXHAUSTED with the numbers for a scene larger than the whole cache.
  absl::StatusOr<ScenePtr> Get(const std::string& name, const Loader& loader, bool* was_here = nullptr);
  void Forget(const std::string& name);

  struct Counters {
    uint64_t hits = 0;
    uint64_t misses = 0;
    uint64_t bytes = 0;
  };
  Counters counters() const;

 private:
  struct Entry {
    ScenePtr scene;
    uint64_t bytes = 0;
    std::list<std::string>::iterator use;
  };
  absl::StatusOr<ScenePtr> LoadFitting(const Loader& loader) const;
  void Keep(const std::string& name, const ScenePtr& scene);  // under mutex_

  const uint64_t max_bytes_;
  const std::function<void(const std::string& name)> on_drop_;
  mutable std::mutex mutex_;
  std::map<std::string, Entry> entries_;
  std::list<std::string> uses_;  // most recent first
  std::map<std::string, std::shared_future<absl::StatusOr<ScenePtr>>> loading_;
  Counters counters_;
};

}  // namespace halfshade
