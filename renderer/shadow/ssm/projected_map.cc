#include "renderer/shadow/ssm/projected_map.h"

#include <glad/gl.h>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/fullscreen.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr double kNanosecondsPerPixel = 60;  // llvmpipe, two cores
constexpr int kTexelsUnit = kPlanesUnit + 1;

}  // namespace

absl::StatusOr<ProjectedMap> MakeProjectedMap(const gl::Context& context, const ReceiverMap& receivers,
                                              std::span<const float> hidden) {
  std::vector<glm::vec2> texels(hidden.size());
  for (size_t i = 0; i < hidden.size(); ++i) {
    const float z = receivers.light_z[i];
    if (z > 0) texels[i] = {hidden[i], 1 / z};
  }
  ProjectedMap map;
  map.window = receivers.window;
  map.casts = receivers.casts;
  ASSIGN_OR_RETURN(map.texels,
                   gl::Texture::Create2D(context, GL_RG32F, receivers.receivers.width, receivers.receivers.height));
  RETURN_IF_ERROR(map.texels.WriteFloats(&texels[0].x, 2 * texels.size()));
  return map;
}

absl::StatusOr<gl::Texture> Project(const DrawContext& draw, const ProjectedMap& map, const AreaLight& light,
                                    const Receivers& receivers) {
  const GladGLContext& gl = draw.context->gl();
  ASSIGN_OR_RETURN(gl::Texture hidden,
                   gl::Texture::Create2D(*draw.context, GL_R32F, receivers.width, receivers.height));
  ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw.context, {&hidden}));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "ssm/project.frag"));
  framebuffer.Bind();
  gl.Viewport(0, 0, receivers.width, receivers.height);
  gl.Disable(GL_DEPTH_TEST);
  gl.Disable(GL_BLEND);
  program->Use();
  SetReceivers(*program, receivers, light);
  map.texels.Bind(kTexelsUnit);
  program->Set("texels", kTexelsUnit);
  program->Set("window_low", glm::vec2(map.window));
  program->Set("slope_per_texel", float((map.window.z - map.window.x) / map.texels.width()));
  program->Set("casts", int(map.casts));
  RETURN_IF_ERROR(DrawFullscreen(draw, receivers.width, receivers.height, kNanosecondsPerPixel));
  RETURN_IF_ERROR(draw.context->Check("ssm/project"));
  return hidden;
}

}  // namespace halfshade
