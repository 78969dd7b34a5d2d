#include "server/scene_cache.h"

#include "renderer/status.h"

namespace halfshade {

absl::StatusOr<SceneCache::ScenePtr> SceneCache::Get(const std::string& name, const Loader& loader, bool* was_here) {
  std::promise<absl::StatusOr<ScenePtr>> promise;
  std::shared_future<absl::StatusOr<ScenePtr>> other;
  {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(name);
    if (was_here != nullptr) *was_here = found != entries_.end();
    if (found != entries_.end()) {
      ++counters_.hits;
      uses_.splice(uses_.begin(), uses_, found->second.use);
      return found->second.scene;
    }
    ++counters_.misses;
    const auto [load, is_first] = loading_.try_emplace(name);
    if (is_first) {
      load->second = promise.get_future().share();
    } else {
      other = load->second;
    }
  }
  if (other.valid()) return other.get();
  const absl::StatusOr<ScenePtr> result = LoadFitting(loader);
  {
    const std::lock_guard lock(mutex_);
    if (result.ok()) Keep(name, *result);
    loading_.erase(name);
  }
  promise.set_value(result);
  return result;
}

absl::StatusOr<SceneCache::ScenePtr> SceneCache::LoadFitting(const Loader& loader) const {
  ASSIGN_OR_RETURN(FlatScene scene, loader());
  const uint64_t bytes = scene.SizeBytes();
  if (bytes > max_bytes_) {
    return absl::ResourceExhaustedError("the scene takes " + std::to_string(bytes) + " bytes; the scene cache holds " +
                                        std::to_string(max_bytes_));
  }
  return std::make_shared<const FlatScene>(std::move(scene));
}

void SceneCache::Keep(const std::string& name, const ScenePtr& scene) {
  uses_.push_front(name);
  entries_[name] = {scene, scene->SizeBytes(), uses_.begin()};
  counters_.bytes += entries_[name].bytes;
  while (counters_.bytes > max_bytes_) {
    const auto oldest = entries_.find(uses_.back());
    counters_.bytes -= oldest->second.bytes;
    on_drop_(oldest->first);
    entries_.erase(oldest);
    uses_.pop_back();
  }
}

void SceneCache::Forget(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(name);
  if (found == entries_.end()) return;
  counters_.bytes -= found->second.bytes;
  on_drop_(name);
  uses_.erase(found->second.use);
  entries_.erase(found);
}

SceneCache::Counters SceneCache::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

}  // namespace halfshade
