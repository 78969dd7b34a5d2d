#include "renderer/seen_view.h"

#include "renderer/cache_key.h"
#include "renderer/light/light_data.h"

namespace halfshade {

uint64_t SeenView::SizeBytes() const {
  uint64_t bytes = 0;
  for (const gl::Texture* texture : {&gbuffer.planes, &gbuffer.normals, &gbuffer.base_colors, &gbuffer.emissions,
                                     &gbuffer.object_ids, &gbuffer.depth}) {
    bytes += texture->SizeBytes();
  }
  if (on_cpu) bytes += on_cpu->planes.size() * sizeof(glm::vec4);
  return bytes;
}

std::string SeenViewKey(const std::string& scene_name, const RenderRequest& request, GBufferChannels channels) {
  std::string key = LightDataPrefix(scene_name);
  const Camera& camera = request.camera;
  AppendBytes(&key, request.scene_index, request.width, request.height, channels.materials, channels.object_ids,
              camera.eye_ws, camera.right_ws, camera.up_ws, camera.forward_ws, camera.is_orthographic,
              camera.tan_half_fovy, camera.ortho_height_m, camera.near_m, camera.far_m, camera.shift_ndc,
              request.ground.has_value());
  // The ground lies under the camera's target.
  if (request.ground) AppendBytes(&key, request.ground->height_m, request.ground->size_m, camera.target_ws);
  for (const NodeOverride& change : request.node_overrides) {
    AppendBytes(&key, change.node, change.is_visible, change.receives, change.local.has_value());
    if (change.local) AppendBytes(&key, *change.local);
  }
  return key;
}

}  // namespace halfshade
