// The ray scenes that were asked for last, up to a number of bytes. One thread.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <list>
#include <memory>
#include <string>

#include "renderer/scene/ray_scene.h"

namespace halfshade {

class RaySceneCache {
 public:
  static constexpr uint64_t kMaxBytes = 512ull << 20;

  explicit RaySceneCache(uint64_t max_bytes = kMaxBytes) : max_bytes_(max_bytes) {}

  struct Found {
    std::shared_ptr<const RayScene> scene;
    bool is_new = false;
  };
  // The casters of `pose` in the scene of this name; built at the first call. Those asked for longest ago go when all
  // together take more than max_bytes, but for the one that is returned; whoever still holds one keeps it.
  absl::StatusOr<Found> Get(const std::string& scene_name, const FlatScene& scene, const Pose& pose);

  void Forget(const std::string& scene_name);
  uint64_t SizeBytes() const;

 private:
  struct Entry {
    std::string scene_name;
    std::vector<Instance> casters;
    std::shared_ptr<const RayScene> scene;
  };
  const uint64_t max_bytes_;
  std::list<Entry> entries_;  // the last asked for in front
};

}  // namespace halfshade
