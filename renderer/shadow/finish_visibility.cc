#include "renderer/shadow/finish_visibility.h"

#include <glad/gl.h>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/fullscreen.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr double kNanosecondsPerPixel = 30;  // llvmpipe, two cores
constexpr int kSumsUnit = kPlanesUnit + 1;

}  // namespace

absl::StatusOr<gl::Texture> FinishVisibility(const DrawContext& draw, const OcclusionSum* occlusion,
                                             const Receivers& receivers, const AreaLight& light) {
  const GladGLContext& gl = draw.context->gl();
  ASSIGN_OR_RETURN(gl::Texture visibility,
                   gl::Texture::Create2D(*draw.context, GL_RG32F, receivers.width, receivers.height));
  ASSIGN_OR_RETURN(gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw.context, {&visibility}));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "shadow/finish.frag"));
  framebuffer.Bind();
  gl.Viewport(0, 0, receivers.width, receivers.height);
  gl.Disable(GL_DEPTH_TEST);
  gl.Disable(GL_BLEND);
  program->Use();
  SetReceivers(*program, receivers, light);
  if (occlusion != nullptr) occlusion->sums.Bind(kSumsUnit);
  program->Set("hidden_sums", kSumsUnit);
  program->Set("has_sums", int(occlusion != nullptr));
  program->Set("full_sum", occlusion != nullptr ? occlusion->full_sum : 1.0f);
  program->Set("half_edges", glm::vec2(light.width_m / 2, light.height_m / 2));
  RETURN_IF_ERROR(DrawFullscreen(draw, receivers.width, receivers.height, kNanosecondsPerPixel));
  RETURN_IF_ERROR(draw.context->Check("shadow/finish"));
  return visibility;
}

}  // namespace halfshade
