// Primary visibility: the receiver plane seen through each pixel and, for frames, what shading needs of it.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/texture.h"
#include "renderer/light/receivers.h"
#include "renderer/request.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene_on_context.h"

namespace halfshade {

// [height][width], row 0 on top.
struct GBuffer {
  gl::Texture planes;       // RGBA32F, see Receivers
  gl::Texture normals;      // RGBA16F world shading normals; empty unless with_materials
  gl::Texture base_colors;  // RGBA16F linear; empty unless with_materials
  gl::Texture depth;
  uint64_t triangles_drawn = 0;
};

// Draws every visible instance and the request's ground, nearest first in depth, back faces culled but on double-sided
// materials. with_materials needs SceneOnContext::NeedMaterials.
absl::StatusOr<GBuffer> DrawGBuffer(const DrawContext& draw, const FlatScene& scene, const SceneOnContext& on_context,
                                    const Pose& pose, const RenderRequest& request, bool with_materials);

}  // namespace halfshade
