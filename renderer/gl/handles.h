// Move-only owners of GL objects. A moved-from or default one owns nothing. They must die on their context's thread,
// with the context current.
#pragma once

#include <absl/status/statusor.h>
#include <glad/gl.h>

#include <utility>
#include <vector>

#include "renderer/gl/context.h"

namespace halfshade::gl {

// An object name and how to delete it. `Deleter` is a type with static void Delete(const GladGLContext&, GLuint).
template <typename Deleter>
class Handle {
 public:
  Handle() = default;
  Handle(const Context& context, GLuint id) : gl_(&context.gl()), id_(id) {}
  Handle(Handle&& other) noexcept : gl_(other.gl_), id_(std::exchange(other.id_, 0)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(gl_, other.gl_);
    std::swap(id_, other.id_);
    return *this;
  }
  ~Handle() {
    if (id_ != 0) Deleter::Delete(*gl_, id_);
  }
  GLuint id() const { return id_; }
  const GladGLContext& gl() const { return *gl_; }
  explicit operator bool() const { return id_ != 0; }

 private:
  const GladGLContext* gl_ = nullptr;
  GLuint id_ = 0;
};

struct DeleteBuffer {
  static void Delete(const GladGLContext& gl, GLuint id) { gl.DeleteBuffers(1, &id); }
};
struct DeleteVertexArray {
  static void Delete(const GladGLContext& gl, GLuint id) { gl.DeleteVertexArrays(1, &id); }
};
struct DeleteTexture {
  static void Delete(const GladGLContext& gl, GLuint id) { gl.DeleteTextures(1, &id); }
};
struct DeleteSampler {
  static void Delete(const GladGLContext& gl, GLuint id) { gl.DeleteSamplers(1, &id); }
};
struct DeleteFramebuffer {
  static void Delete(const GladGLContext& gl, GLuint id) { gl.DeleteFramebuffers(1, &id); }
};
struct DeleteShader {
  static void Delete(const GladGLContext& gl, GLuint id) { gl.DeleteShader(id); }
};
struct DeleteProgram {
  static void Delete(const GladGLContext& gl, GLuint id) { gl.DeleteProgram(id); }
};

class VertexArray : public Handle<DeleteVertexArray> {
 public:
  using Handle::Handle;
  static VertexArray Create(const Context& context);
  // Attribute `index` is `components` floats of a tightly packed buffer.
  void SetFloats(GLuint index, GLint components, GLuint buffer) const;
};

// Repeating, linear with mips, until its parameters are set. Bound beside a texture it rules in place of the texture's
// own parameters: unbind it (0) when done.
class Sampler : public Handle<DeleteSampler> {
 public:
  using Handle::Handle;
  static Sampler Create(const Context& context);
};

// Immutable contents.
class Buffer : public Handle<DeleteBuffer> {
 public:
  using Handle::Handle;
  // RESOURCE_EXHAUSTED when GL has no memory for it.
  static absl::StatusOr<Buffer> Create(const Context& context, const void* data, size_t size_bytes);
  template <typename T>
  static absl::StatusOr<Buffer> Create(const Context& context, const std::vector<T>& values) {
    return Create(context, values.data(), values.size() * sizeof(T));
  }
};

}  // namespace halfshade::gl
