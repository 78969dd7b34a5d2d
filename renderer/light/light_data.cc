#include "renderer/light/light_data.h"

#include "renderer/cache_key.h"

namespace halfshade {

std::string LightDataPrefix(const std::string& scene_name) { return scene_name + "\n"; }

std::string LightDataKey(const std::string& scene_name, const RenderRequest& request, const AreaLight& side,
                         const std::string& method, const std::string& options) {
  std::string key = LightDataPrefix(scene_name) + method + "\n" + options + "\n";
  AppendBytes(&key, request.seed, request.scene_index, side.center_ws, side.axis_u_ws, side.axis_v_ws, side.normal_ws,
              side.width_m, side.height_m);
  for (const NodeOverride& change : request.node_overrides) {
    if (!change.local && change.casts && change.receives) continue;
    AppendBytes(&key, change.node, change.casts, change.receives, change.local.has_value());
    if (change.local) AppendBytes(&key, *change.local);
  }
  return key;
}

std::string ReceiverMapKey(const RenderRequest& request) {
  std::string key;
  AppendBytes(&key, request.light_map_size, request.ground.has_value());
  // The ground lies under the camera's target.
  if (request.ground) AppendBytes(&key, request.ground->height_m, request.ground->size_m, request.camera.target_ws);
  for (const NodeOverride& change : request.node_overrides) {
    if (!change.is_visible) AppendBytes(&key, change.node);
  }
  return key;
}

std::string CastersKey(const std::string& scene_name, const RenderRequest& request) {
  std::string key = LightDataPrefix(scene_name);
  AppendBytes(&key, request.scene_index);
  for (const NodeOverride& change : request.node_overrides) {
    // What does not cast, with all below it, is no caster wherever it stands.
    if (!change.casts) {
      AppendBytes(&key, change.node, false);
    } else if (change.local) {
      AppendBytes(&key, change.node, true, *change.local);
    }
  }
  return key;
}

}  // namespace halfshade
