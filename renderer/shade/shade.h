// Visibility times unshadowed light, summed over lights: the frame.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/texture.h"
#include "renderer/light/receivers.h"
#include "renderer/request.h"
#include "renderer/shade/gbuffer.h"

namespace halfshade {

// The fitted tables of the specular (renderer/shade/ltc) on a context: made once, 96 KiB.
class LtcTextures {
 public:
  static absl::StatusOr<LtcTextures> Create(const gl::Context& context);
  // Binds both to units first_unit and the next, and sets the uniforms of common/ltc.glsl.
  void Bind(gl::Program& program, int first_unit) const;

 private:
  gl::Texture lobes_, albedos_;
};

// RGBA32F: emission, ambient light and background, exposed; alpha is coverage. Lights are added to it.
absl::StatusOr<gl::Texture> StartFrame(const DrawContext& draw, const LtcTextures& ltc, const GBuffer& gbuffer,
                                       const Receivers& receivers, const RenderRequest& request);

// Adds a light, times visibility (red channel), which shadows both of
// - diffuse: exact for rectangles and points (Lambert's polygon formula), to 8 samples for lines;
// - specular: GGX by linearly transformed cosines for rectangles and, as thin strips, for lines; the BRDF for points.
absl::Status AddLight(const DrawContext& draw, const LtcTextures& ltc, const GBuffer& gbuffer,
                      const Receivers& receivers, const AreaLight& light, const gl::Texture& visibility,
                      const RenderRequest& request, gl::Texture& frame);

}  // namespace halfshade
