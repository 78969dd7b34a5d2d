#include "renderer/scene/ray_scene_cache.h"

#include <algorithm>

#include "renderer/status.h"

namespace halfshade {
namespace {

std::vector<Instance> Casters(const Pose& pose) {
  std::vector<Instance> casters;
  for (const Instance& instance : pose.instances) {
    if (instance.casts) casters.push_back(instance);
  }
  return casters;
}

bool AreSame(const std::vector<Instance>& a, const std::vector<Instance>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Instance& x, const Instance& y) {
    return x.mesh == y.mesh && x.world_from_mesh == y.world_from_mesh;
  });
}

}  // namespace

absl::StatusOr<RaySceneCache::Found> RaySceneCache::Get(const std::string& scene_name, const FlatScene& scene,
                                                        const Pose& pose) {
  std::vector<Instance> casters = Casters(pose);
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return entry.scene_name == scene_name && AreSame(entry.casters, casters);
  });
  if (found != entries_.end()) {
    entries_.splice(entries_.begin(), entries_, found);
    return Found{entries_.front().scene, false};
  }
  ASSIGN_OR_RETURN(std::shared_ptr<const RayScene> built, RayScene::Create(scene, pose));
  entries_.push_front({scene_name, std::move(casters), built});
  while (entries_.size() > 1 && SizeBytes() > max_bytes_) entries_.pop_back();
  return Found{std::move(built), true};
}

void RaySceneCache::Forget(const std::string& scene_name) {
  entries_.remove_if([&](const Entry& entry) { return entry.scene_name == scene_name; });
}

uint64_t RaySceneCache::SizeBytes() const {
  uint64_t bytes = 0;
  for (const Entry& entry : entries_) bytes += entry.scene->SizeBytes();
  return bytes;
}

}  // namespace halfshade
