// The renderer's LightStore over the store on disk. Reading blocks the caller, a GL worker, for what it saves many
// times over; writing is left to a pool, and what a second write would delay by more than kMaxPendingBytes is not kept.
#pragma once

#include <atomic>
#include <string>

#include "renderer/renderer.h"
#include "server/cpu_pool.h"
#include "server/store.h"

namespace halfshade {

class LightDataStore final : public LightStore {
 public:
  static constexpr uint64_t kMaxPendingBytes = 512 << 20;
  // Both outlive it; `pool` is joined before it dies.
  LightDataStore(Store* store, CpuPool* pool) : store_(store), pool_(pool) {}
  std::string Get(const std::string& scene_name, const std::string& key) override;
  void Put(const std::string& scene_name, const std::string& key, std::string bytes) override;

 private:
  Store* store_;
  CpuPool* pool_;
  std::atomic<uint64_t> pending_bytes_{0};
};

// All light data of a scene.
absl::Status RemoveLightData(Store* store, const std::string& scene_name);

}  // namespace halfshade
