// The occluders of one light in GL buffers, and the pass that draws them into a depth map.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/handles.h"
#include "renderer/light/occluders.h"
#include "renderer/scene/scene_on_context.h"

namespace halfshade {

class OccludersOnContext {
 public:
  // `on_context` has the textures of the masked occluders' materials (SceneOnContext::NeedTextures); it need not
  // outlive the result.
  static absl::StatusOr<std::unique_ptr<OccludersOnContext>> Create(const DrawContext& draw, const FlatScene& scene,
                                                                    const SceneOnContext& on_context,
                                                                    const LightSpaceOccluders& occluders);

  // Draws all of them into the bound depth framebuffer (size x size, cleared by the caller) as seen from `point` of the
  // light, in submissions that stay within the pacer's bound. `window`: u0, v0, texels per slope along u and v.
  absl::Status DrawDepth(const DrawContext& draw, int side, const glm::dvec2& point, const glm::dvec4& window,
                         int size) const;

  const OccluderHull& hull() const { return hull_; }
  uint64_t triangle_count() const { return index_count_ / 3; }
  uint64_t SizeBytes() const { return size_bytes_; }

 private:
  // Masked triangles of one material.
  struct Masked {
    MaskedOccluders range;
    SampledTexture mask;     // empty: the vertices' alpha alone
    float alpha_cutoff = 0;  // of MASK
    bool is_blend = false;
  };
  OccludersOnContext() = default;
  absl::Status DrawRange(const DrawContext& draw, uint64_t first_index, uint64_t index_count, int base_vertex) const;

  gl::VertexArray vertex_array_, masked_vertex_array_;
  gl::Buffer positions_, indices_, mask_vertices_, blend_places_;
  std::vector<Masked> masked_;
  uint64_t opaque_index_count_ = 0;
  uint32_t first_masked_vertex_ = 0;
  OccluderHull hull_{0, 0, 1};
  uint64_t index_count_ = 0;
  uint64_t size_bytes_ = 0;
};

}  // namespace halfshade
