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
  gl::Texture planes;  // RGBA32F, see Receivers
  // Empty unless channels.materials.
  gl::Texture normals;      // RGBA32F world shading normals, turned to the side that is seen; a: roughness. In halves a
                            // mirror's reflections would step
  gl::Texture base_colors;  // RGBA16F linear; a: metallic
  gl::Texture emissions;    // RGBA16F radiance, not exposed; a: what occlusion maps leave of ambient light
  gl::Texture object_ids;   // R32F, OutputKind::kObjectId; empty unless channels.object_ids
  gl::Texture depth;
  uint64_t triangles_drawn = 0;
  uint64_t triangles_out_of_view = 0;  // left out, by cluster
};

struct GBufferChannels {
  bool materials = false;  // needs SceneOnContext::NeedTextures
  bool object_ids = false;
};

// What kObjectId says where the ground is seen.
uint32_t GroundId(const FlatScene& scene);

// Draws what the camera may see of every visible instance, and the request's ground, nearest first in depth, back faces
// culled but on double-sided materials, masked ones only where they are. Needs SceneOnContext::NeedTextures for
// channels.materials and for masks.
absl::StatusOr<GBuffer> DrawGBuffer(const DrawContext& draw, const FlatScene& scene, const SceneOnContext& on_context,
                                    const Pose& pose, const RenderRequest& request, GBufferChannels channels);

}  // namespace halfshade
