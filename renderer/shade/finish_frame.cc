#include "renderer/shade/finish_frame.h"

#include <glad/gl.h>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/fullscreen.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr double kNanosecondsPerPixel = 40;  // llvmpipe, two cores
constexpr int kFrameUnit = 0;
constexpr int kUnshadowedUnit = 1;
constexpr int kObjectIdsUnit = 2;

}  // namespace

bool FrameSamples::AreNeeded(const RenderRequest& request) {
  return request.samples > 1 || request.shading.tone_map != ToneMap::kNone ||
         (request.ground && request.ground->is_shadow_catcher);
}

absl::Status FrameSamples::Add(const DrawContext& draw, const gl::Texture& frame, const Catcher* catcher,
                               const RenderRequest& request) {
  const GladGLContext& gl = draw.context->gl();
  const bool is_first = !sum_;
  if (is_first) {
    ASSIGN_OR_RETURN(sum_, gl::Texture::Create2D(*draw.context, GL_RGBA32F, request.width, request.height));
  }
  ASSIGN_OR_RETURN(gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw.context, {&sum_}));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "shade/finish_frame.frag"));
  framebuffer.Bind();
  gl.Viewport(0, 0, request.width, request.height);
  gl.Disable(GL_DEPTH_TEST);
  program->Use();
  frame.Bind(kFrameUnit);
  program->Set("frame", kFrameUnit);
  program->Set("unshadowed", kUnshadowedUnit);
  program->Set("object_ids", kObjectIdsUnit);
  program->Set("has_catcher", int(catcher != nullptr));
  if (catcher != nullptr) {
    catcher->unshadowed->Bind(kUnshadowedUnit);
    catcher->object_ids->Bind(kObjectIdsUnit);
    program->Set("ground_id", float(catcher->ground_id));
  }
  program->Set("tone_map", int(request.shading.tone_map));
  program->Set("weight", 1.0f / float(request.samples));  // a power of two
  if (is_first) {
    gl.Disable(GL_BLEND);
  } else {
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ONE, GL_ONE);
  }
  RETURN_IF_ERROR(DrawFullscreen(draw, request.width, request.height, kNanosecondsPerPixel));
  gl.Disable(GL_BLEND);
  return draw.context->Check("shade/finish_frame");
}

}  // namespace halfshade
