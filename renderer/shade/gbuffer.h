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
  gl::Texture normals;      // RGBA16F world shading normals; empty unless channels.materials
  gl::Texture base_colors;  // RGBA16F linear; empty unless channels.materials
  gl::Texture object_ids;   // R32F, OutputKind::kObjectId; empty unless channels.object_ids
  gl::Texture depth;
  uint64_t triangles_drawn = 0;
};

struct GBufferChannels {
  bool materials = false;  // needs SceneOnContext::NeedMaterials
  bool object_ids = false;
};

// What kObjectId says where the ground is seen.
uint32_t GroundId(const FlatScene& scene);

// Draws every visible instance and the request's ground, nearest first in depth, back faces culled but on double-sided
// materials.
absl::StatusOr<GBuffer> DrawGBuffer(const DrawContext& draw, const FlatScene& scene, const SceneOnContext& on_context,
                                    const Pose& pose, const RenderRequest& request, GBufferChannels channels);

}  // namespace halfshade
