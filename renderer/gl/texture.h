// Immutable 2D textures and 2D arrays. Row 0 is the image's top row by our convention (drawn flipped).
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>

#include "renderer/gl/handles.h"

namespace halfshade::gl {

class Texture : public Handle<DeleteTexture> {
 public:
  using Handle::Handle;
  // Sized internal formats; nearest filter, clamped. Contents are undefined. RESOURCE_EXHAUSTED without memory.
  static absl::StatusOr<Texture> Create2D(const Context& context, GLenum format, int width, int height);
  static absl::StatusOr<Texture> Create2DArray(const Context& context, GLenum format, int width, int height,
                                               int layers);
  // With storage for all mip levels (fill level 0, then glGenerateTextureMipmap).
  static absl::StatusOr<Texture> Create2DWithMips(const Context& context, GLenum format, int width, int height);

  void Bind(int unit) const;
  // Reads level 0 of an R16F, R32F, RG32F, RGBA32F or depth texture: [height][width][channels], `count` floats in all
  // (asserted). Waits for the drawing.
  absl::Status ReadFloats(float* values, size_t count) const;

  // Fills level 0 of such a colour texture, from the same form.
  absl::Status WriteFloats(const float* values, size_t count) const;

  int width() const { return width_; }
  int height() const { return height_; }
  uint64_t SizeBytes() const { return size_bytes_; }

 private:
  static absl::StatusOr<Texture> Create(const Context& context, GLenum target, GLenum format, int width, int height,
                                        int layers, int levels);
  GLenum format_ = 0;
  int width_ = 0;
  int height_ = 0;
  uint64_t size_bytes_ = 0;
};

}  // namespace halfshade::gl
