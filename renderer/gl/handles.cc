#include "renderer/gl/handles.h"

#include <string>

namespace halfshade::gl {

VertexArray VertexArray::Create(const Context& context) {
  GLuint id = 0;
  context.gl().CreateVertexArrays(1, &id);
  return VertexArray(context, id);
}

void VertexArray::SetFloats(GLuint index, GLint components, GLuint buffer) const {
  gl().VertexArrayVertexBuffer(id(), index, buffer, 0, components * GLsizei(sizeof(float)));
  gl().VertexArrayAttribFormat(id(), index, components, GL_FLOAT, GL_FALSE, 0);
  gl().VertexArrayAttribBinding(id(), index, index);
  gl().EnableVertexArrayAttrib(id(), index);
}

Sampler Sampler::Create(const Context& context) {
  GLuint id = 0;
  context.gl().CreateSamplers(1, &id);
  return Sampler(context, id);
}

absl::StatusOr<Buffer> Buffer::Create(const Context& context, const void* data, size_t size_bytes) {
  GLuint id = 0;
  context.gl().CreateBuffers(1, &id);
  Buffer buffer(context, id);
  context.gl().NamedBufferStorage(id, GLsizeiptr(size_bytes), data, 0);
  if (const absl::Status status = context.Check("creating a buffer"); !status.ok()) {
    if (!absl::IsResourceExhausted(status)) return status;
    return absl::ResourceExhaustedError("GL has no room for a buffer of " + std::to_string(size_bytes) +
                                        " bytes: " + std::string(status.message()));
  }
  return buffer;
}

}  // namespace halfshade::gl
