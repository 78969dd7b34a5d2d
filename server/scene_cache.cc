#include "server/scene_cache.h"

#include <chrono>

#include "renderer/status.h"
#include "server/status.h"

namespace halfshade {
namespace {

constexpr auto kComeBack = std::chrono::milliseconds(200);  // a render's time
constexpr size_t kMaxSizes = 4096;

}  // namespace

absl::StatusOr<SceneCache::ScenePtr> SceneCache::Get(const std::string& name, const Loader& loader) {
  std::promise<absl::StatusOr<ScenePtr>> promise;
  std::shared_future<absl::StatusOr<ScenePtr>> other;
  {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(name);
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
  absl::StatusOr<ScenePtr> result = Load(name, loader);
  {
    const std::lock_guard lock(mutex_);
    loading_.erase(name);
  }
  promise.set_value(result);
  return result;
}

absl::StatusOr<SceneCache::ScenePtr> SceneCache::Load(const std::string& name, const Loader& loader) {
  uint64_t reserved = 0;
  {
    const std::lock_guard lock(mutex_);
    if (const auto size = sizes_.find(name); size != sizes_.end()) {
      RETURN_IF_ERROR(MakeRoom(size->second));
      reserved = size->second;
      *bytes_ += reserved;
    }
  }
  absl::StatusOr<FlatScene> scene = loader();
  const std::lock_guard lock(mutex_);
  *bytes_ -= reserved;
  RETURN_IF_ERROR(scene.status());
  const uint64_t bytes = scene->SizeBytes();
  if (sizes_.size() >= kMaxSizes) sizes_.clear();
  sizes_[name] = bytes;
  RETURN_IF_ERROR(MakeRoom(bytes));
  *bytes_ += bytes;
  const ScenePtr counted(new FlatScene(*std::move(scene)), [bytes, total = bytes_](const FlatScene* mine) {
    delete mine;
    *total -= bytes;
  });
  uses_.push_front(name);
  entries_[name] = {counted, bytes, uses_.begin()};
  return counted;
}

absl::Status SceneCache::MakeRoom(uint64_t bytes) {
  if (bytes > max_bytes_) {
    return absl::InvalidArgumentError("the scene takes " + std::to_string(bytes) +
                                      " bytes; the scene cache of this server holds " + std::to_string(max_bytes_));
  }
  // Under mutex_ nobody can come to a scene that the cache alone holds.
  const auto is_idle = [](const Entry& entry) { return entry.scene.use_count() == 1; };
  uint64_t idle_bytes = 0;
  for (const auto& [name, entry] : entries_) idle_bytes += is_idle(entry) ? entry.bytes : 0;
  const uint64_t in_use = *bytes_ - idle_bytes;
  if (in_use + bytes > max_bytes_) {
    return ComeBackLater("the scene takes " + std::to_string(bytes) + " bytes; " + std::to_string(in_use) + " of the " +
                             std::to_string(max_bytes_) + " of the scene cache are in use",
                         kComeBack);
  }
  for (auto use = uses_.end(); *bytes_ + bytes > max_bytes_ && use != uses_.begin();) {
    const auto entry = entries_.find(*--use);
    if (!is_idle(entry->second)) continue;
    ++use;
    Drop(entry);
  }
  return absl::OkStatus();
}

void SceneCache::Drop(std::map<std::string, Entry>::iterator entry) {
  on_drop_(entry->first);
  uses_.erase(entry->second.use);
  entries_.erase(entry);
}

void SceneCache::Forget(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto is_of_it = [&](const std::string& key) { return key.starts_with(name); };
  std::erase_if(sizes_, [&](const auto& size) { return is_of_it(size.first); });
  for (auto entry = entries_.lower_bound(name); entry != entries_.end() && is_of_it(entry->first);) Drop(entry++);
}

SceneCache::Counters SceneCache::counters() const {
  const std::lock_guard lock(mutex_);
  Counters counters = counters_;
  counters.bytes = *bytes_;
  return counters;
}

}  // namespace halfshade
