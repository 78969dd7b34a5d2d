// Framebuffers: complete, or a Status.
#pragma once

#include <absl/status/statusor.h>

#include <vector>

#include "renderer/gl/texture.h"

namespace halfshade::gl {

class Framebuffer : public Handle<DeleteFramebuffer> {
 public:
  using Handle::Handle;
  // Color attachments in the order of the shader's outputs, null for one that is dropped; the textures outlive the
  // framebuffer.
  static absl::StatusOr<Framebuffer> Create(const Context& context, const std::vector<const Texture*>& colors,
                                            const Texture* depth = nullptr);
  // Depth only, one layer of an array.
  static absl::StatusOr<Framebuffer> CreateDepthLayer(const Context& context, const Texture& depths, int layer);
  // For drawing.
  void Bind() const;
};

}  // namespace halfshade::gl
