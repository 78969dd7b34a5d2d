#include "renderer/gl/texture.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <string>

namespace halfshade::gl {
namespace {

struct Format {
  int bytes;
  GLenum transfer;  // 0: not read back
  int channels;
};

Format Describe(GLenum format) {
  switch (format) {
    case GL_R32F:
      return {4, GL_RED, 1};
    case GL_R16F:
      return {2, GL_RED, 1};
    case GL_RG32F:
      return {8, GL_RG, 2};
    case GL_RGBA32F:
      return {16, GL_RGBA, 4};
    case GL_RGBA16F:
      return {8, GL_RGBA, 4};
    case GL_DEPTH_COMPONENT32F:
      return {4, GL_DEPTH_COMPONENT, 1};
    case GL_R8:
      return {1, 0, 1};
    case GL_RG16UI:
      return {4, 0, 2};
    case GL_RGBA8:
    case GL_SRGB8_ALPHA8:
      return {4, 0, 4};
    default:
      assert(false && "a format that this room does not know");
      return {16, 0, 4};
  }
}

}  // namespace

absl::StatusOr<Texture> Texture::Create(const Context& context, GLenum target, GLenum format, int width, int height,
                                        int layers, int levels) {
  const GladGLContext& gl = context.gl();
  GLint most = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  if (width > most || height > most) {
    return absl::ResourceExhaustedError("GL has no room for a texture of " + std::to_string(width) + "x" +
                                        std::to_string(height) + " texels: at most " + std::to_string(most) +
                                        " a side here");
  }
  GLuint id = 0;
  gl.CreateTextures(target, 1, &id);
  Texture texture(context, id);
  texture.format_ = format;
  texture.width_ = width;
  texture.height_ = height;
  texture.size_bytes_ = uint64_t(width) * height * layers * Describe(format).bytes * (levels > 1 ? 4 : 3) / 3;
  if (target == GL_TEXTURE_2D) {
    gl.TextureStorage2D(id, levels, format, width, height);
  } else {
    gl.TextureStorage3D(id, levels, format, width, height, layers);
  }
  if (const absl::Status status = context.Check("creating a texture"); !status.ok()) {
    if (!absl::IsResourceExhausted(status)) return status;
    return absl::ResourceExhaustedError("GL has no room for a texture of " + std::to_string(texture.size_bytes_) +
                                        " bytes: " + std::string(status.message()));
  }
  gl.TextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

absl::StatusOr<Texture> Texture::Create2D(const Context& context, GLenum format, int width, int height) {
  return Create(context, GL_TEXTURE_2D, format, width, height, 1, 1);
}

absl::StatusOr<Texture> Texture::Create2DArray(const Context& context, GLenum format, int width, int height,
                                               int layers) {
  return Create(context, GL_TEXTURE_2D_ARRAY, format, width, height, layers, 1);
}

absl::StatusOr<Texture> Texture::Create2DWithMips(const Context& context, GLenum format, int width, int height) {
  const int levels = std::bit_width(unsigned(std::max(width, height)));
  return Create(context, GL_TEXTURE_2D, format, width, height, 1, levels);
}

void Texture::Bind(int unit) const { gl().BindTextureUnit(GLuint(unit), id()); }

absl::Status Texture::ReadFloats(float* values, size_t count) const {
  const Format format = Describe(format_);
  assert(format.transfer != 0 && count == size_t(width_) * height_ * format.channels);
  gl().PixelStorei(GL_PACK_ALIGNMENT, 4);
  gl().GetTextureImage(id(), 0, format.transfer, GL_FLOAT, GLsizei(count * sizeof(float)), values);
  if (const GLenum error = gl().GetError(); error != GL_NO_ERROR) {
    return absl::InternalError("reading a texture back: GL error " + std::to_string(error));
  }
  return absl::OkStatus();
}

absl::Status Texture::WriteFloats(const float* values, size_t count) const {
  const Format format = Describe(format_);
  (void)count;
  assert(format.transfer != 0 && count == size_t(width_) * height_ * format.channels);
  gl().PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  gl().TextureSubImage2D(id(), 0, 0, 0, width_, height_, format.transfer, GL_FLOAT, values);
  if (const GLenum error = gl().GetError(); error != GL_NO_ERROR) {
    return absl::InternalError("filling a texture: GL error " + std::to_string(error));
  }
  return absl::OkStatus();
}

}  // namespace halfshade::gl
