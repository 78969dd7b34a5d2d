#include "server/light_data_store.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "server/digest.h"
#include "server/scene_name.h"

namespace halfshade {
namespace {

constexpr size_t kPrefixDigits = 32;  // 128 bits tell scenes apart, and as many a scene's light data

// Names of one scene begin alike, so that they can be found again without the keys.
std::string PrefixOf(const std::string& scene_name) {
  return Sha256Hex(scene_name.substr(0, scene_name.find(kPoseSeparator))).substr(0, kPrefixDigits);
}
std::string NameOf(const std::string& scene_name, const std::string& key) {
  const size_t pose = scene_name.find(kPoseSeparator);
  const std::string of_pose = pose == std::string::npos ? "" : scene_name.substr(pose);
  return PrefixOf(scene_name) + Sha256Hex(key + of_pose).substr(0, 64 - kPrefixDigits);
}

}  // namespace

std::string LightDataStore::Get(const std::string& scene_name, const std::string& key) {
  absl::StatusOr<std::string> bytes = store_->Get(StoreKind::kLightData, NameOf(scene_name, key));
  return bytes.ok() ? *std::move(bytes) : std::string();
}

void LightDataStore::Put(const std::string& scene_name, const std::string& key, std::string bytes) {
  const uint64_t size = bytes.size();
  if (pending_bytes_.fetch_add(size) + size > kMaxPendingBytes) {
    pending_bytes_ -= size;
    return;
  }
  const auto shared = std::make_shared<const std::string>(std::move(bytes));
  pool_->Run([this, name = NameOf(scene_name, key), shared, size] {
    // What does not fit is built again another time.
    const absl::Status status = store_->Put(StoreKind::kLightData, name, *shared);
    if (!status.ok()) spdlog::info("light data is not kept: {}", std::string(status.message()));
    pending_bytes_ -= size;
  });
}

absl::Status RemoveLightData(Store* store, const std::string& scene_name) {
  std::vector<std::string> names = store->List(StoreKind::kLightData);
  const std::string prefix = PrefixOf(scene_name);
  std::erase_if(names, [&](const std::string& name) { return !name.starts_with(prefix); });
  return names.empty() ? absl::OkStatus() : store->Remove(StoreKind::kLightData, names);
}

}  // namespace halfshade
