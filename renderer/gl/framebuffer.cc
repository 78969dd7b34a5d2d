#include "renderer/gl/framebuffer.h"

#include <string>

namespace halfshade::gl {
namespace {

absl::StatusOr<Framebuffer> Complete(Framebuffer framebuffer) {
  const GLenum status = framebuffer.gl().CheckNamedFramebufferStatus(framebuffer.id(), GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    return absl::InternalError("incomplete framebuffer: GL status " + std::to_string(status));
  }
  return framebuffer;
}

Framebuffer Make(const Context& context) {
  GLuint id = 0;
  context.gl().CreateFramebuffers(1, &id);
  return Framebuffer(context, id);
}

}  // namespace

absl::StatusOr<Framebuffer> Framebuffer::Create(const Context& context, const std::vector<const Texture*>& colors,
                                                const Texture* depth) {
  const GladGLContext& gl = context.gl();
  Framebuffer framebuffer = Make(context);
  std::vector<GLenum> buffers;
  for (const Texture* color : colors) {
    const GLenum attachment = GLenum(GL_COLOR_ATTACHMENT0 + buffers.size());
    if (color != nullptr) gl.NamedFramebufferTexture(framebuffer.id(), attachment, color->id(), 0);
    buffers.push_back(color != nullptr ? attachment : GL_NONE);
  }
  if (depth != nullptr) gl.NamedFramebufferTexture(framebuffer.id(), GL_DEPTH_ATTACHMENT, depth->id(), 0);
  gl.NamedFramebufferDrawBuffers(framebuffer.id(), GLsizei(buffers.size()), buffers.data());
  return Complete(std::move(framebuffer));
}

absl::StatusOr<Framebuffer> Framebuffer::CreateDepthLayer(const Context& context, const Texture& depths, int layer) {
  Framebuffer framebuffer = Make(context);
  context.gl().NamedFramebufferTextureLayer(framebuffer.id(), GL_DEPTH_ATTACHMENT, depths.id(), 0, layer);
  context.gl().NamedFramebufferDrawBuffer(framebuffer.id(), GL_NONE);
  return Complete(std::move(framebuffer));
}

void Framebuffer::Bind() const { gl().BindFramebuffer(GL_DRAW_FRAMEBUFFER, id()); }

}  // namespace halfshade::gl
