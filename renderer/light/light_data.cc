#include "renderer/light/light_data.h"

#include <type_traits>

namespace halfshade {
namespace {

template <typename... Values>
void Append(std::string* key, const Values&... values) {
  static_assert((std::is_trivially_copyable_v<Values> && ...));
  (key->append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
}

}  // namespace

std::string LightDataPrefix(const std::string& scene_name) { return scene_name + "\n"; }

std::string LightDataKey(const std::string& scene_name, const RenderRequest& request, const AreaLight& side,
                         const std::string& method, const std::string& options) {
  std::string key = LightDataPrefix(scene_name) + method + "\n" + options + "\n";
  Append(&key, request.seed, request.scene_index, side.center_ws, side.axis_u_ws, side.axis_v_ws, side.normal_ws,
         side.width_m, side.height_m);
  for (const NodeOverride& change : request.node_overrides) {
    if (!change.local && change.casts && change.receives) continue;
    Append(&key, change.node, change.casts, change.receives, change.local.has_value());
    if (change.local) Append(&key, *change.local);
  }
  return key;
}

std::string ReceiverMapKey(const RenderRequest& request) {
  std::string key;
  Append(&key, request.light_map_size, request.ground.has_value());
  // The ground lies under the camera's target.
  if (request.ground) Append(&key, request.ground->height_m, request.ground->size_m, request.camera.target_ws);
  for (const NodeOverride& change : request.node_overrides) {
    if (!change.is_visible) Append(&key, change.node);
  }
  return key;
}

std::string CastersKey(const std::string& scene_name, const RenderRequest& request) {
  std::string key = LightDataPrefix(scene_name);
  Append(&key, request.scene_index);
  for (const NodeOverride& change : request.node_overrides) {
    // What does not cast, with all below it, is no caster wherever it stands.
    if (!change.casts) {
      Append(&key, change.node, false);
    } else if (change.local) {
      Append(&key, change.node, true, *change.local);
    }
  }
  return key;
}

}  // namespace halfshade
