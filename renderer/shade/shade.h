// Visibility times unshadowed light, summed over lights: the frame.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/texture.h"
#include "renderer/light/receivers.h"
#include "renderer/request.h"
#include "renderer/shade/gbuffer.h"

namespace halfshade {

// RGBA32F: ambient light and background, exposed; alpha is coverage. Lights are added to it.
absl::StatusOr<gl::Texture> StartFrame(const DrawContext& draw, const GBuffer& gbuffer, const RenderRequest& request);

// Adds a light: diffuse, exact for the whole light (Lambert's polygon formula), times visibility (red channel).
absl::Status AddLight(const DrawContext& draw, const GBuffer& gbuffer, const Receivers& receivers,
                      const AreaLight& light, const gl::Texture& visibility, const RenderRequest& request,
                      gl::Texture& frame);

}  // namespace halfshade
