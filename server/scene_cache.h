// Flat scenes in memory: least recently used go first, identical loads are done once, and a scene in use is neither
// evicted nor left out of the count. Thread-safe.
#pragma once

#include <absl/status/statusor.h>

#include <atomic>
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
  // In use as long as somebody beside the cache holds it.
  using ScenePtr = std::shared_ptr<const FlatScene>;
  using Loader = std::function<absl::StatusOr<FlatScene>()>;

  // Bound of what is held and in use together. A scene that is being loaded for the first time comes on top until its
  // size is known. `on_drop` is told the name of every scene that leaves the cache, under its lock: it must not call
  // back.
  explicit SceneCache(
      uint64_t max_bytes, std::function<void(const std::string& name)> on_drop = [](const std::string&) {})
      : max_bytes_(max_bytes), on_drop_(std::move(on_drop)) {}

  // The scene, loaded by `loader` if it is not here; callers that come while it loads wait for the same result. Errors
  // of the loader are not kept. INVALID_ARGUMENT with the numbers for a scene larger than the whole cache;
  // RESOURCE_EXHAUSTED with push-back (status.h) where scenes in use leave no room for it.
  absl::StatusOr<ScenePtr> Get(const std::string& name, const Loader& loader);
  // Every scene whose name begins so: a scene and its poses (scene_catalog.h). What is in use stays with its users.
  void Forget(const std::string& name);

  struct Counters {
    uint64_t hits = 0;
    uint64_t misses = 0;
    uint64_t bytes = 0;  // held or in use
  };
  Counters counters() const;

 private:
  struct Entry {
    ScenePtr scene;
    uint64_t bytes = 0;
    std::list<std::string>::iterator use;
  };
  absl::StatusOr<ScenePtr> Load(const std::string& name, const Loader& loader);
  // Under mutex_.
  absl::Status MakeRoom(uint64_t bytes);
  void Drop(std::map<std::string, Entry>::iterator entry);

  const uint64_t max_bytes_;
  const std::function<void(const std::string& name)> on_drop_;
  mutable std::mutex mutex_;
  std::map<std::string, Entry> entries_;
  std::list<std::string> uses_;  // most recent first
  std::map<std::string, std::shared_future<absl::StatusOr<ScenePtr>>> loading_;
  // What scenes were found to take, so that one without room is refused before it is loaded again.
  std::map<std::string, uint64_t> sizes_;
  Counters counters_;
  // Of every scene alive, those that are being loaded with a known size included. Shared with the scenes, which may
  // outlive the cache.
  std::shared_ptr<std::atomic<uint64_t>> bytes_ = std::make_shared<std::atomic<uint64_t>>(0);
};

}  // namespace halfshade
