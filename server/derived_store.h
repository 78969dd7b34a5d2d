// What is made of a scene and can be made again, over the store on disk: its flat form, and the renderer's light data.
// Reading blocks the caller for what it saves many times over; writing is left to a pool, and what a second write would
// delay by more than kMaxPendingBytes is not kept. Thread-safe.
#pragma once

#include <atomic>
#include <string>

#include "renderer/renderer.h"
#include "server/cpu_pool.h"
#include "server/store.h"

namespace halfshade {

class DerivedStore final : public LightStore {
 public:
  static constexpr uint64_t kMaxPendingBytes = 512 << 20;
  // Both outlive it; `pool` is joined before it dies.
  DerivedStore(Store* store, CpuPool* pool) : store_(store), pool_(pool) {}
  std::string Get(const std::string& scene_name, const std::string& key) override;
  void Put(const std::string& scene_name, const std::string& key, std::string bytes) override;

 private:
  Store* store_;
  CpuPool* pool_;
  std::atomic<uint64_t> pending_bytes_{0};
};

// All that is derived of a scene.
absl::Status RemoveDerived(Store* store, const std::string& scene_name);

}  // namespace halfshade
