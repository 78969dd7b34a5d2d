#include "renderer/scene/ray_mask.h"

#include <algorithm>
#include <cmath>

#include "renderer/status.h"

namespace halfshade {
namespace {

// Masks are asked at every ray or sample that meets one: no division of whole numbers, no call.
int Floor(float value) {
  const int whole = int(value);
  return whole - int(value < float(whole));
}

// The index of a texel in [-1, 2 size], as GL wraps it.
int WrapTexel(int texel, int size, Wrap wrap) {
  if (wrap == Wrap::kClampToEdge) return std::clamp(texel, 0, size - 1);
  const int period = wrap == Wrap::kRepeat ? size : 2 * size;
  int in_period = texel < 0 ? texel + period : texel;
  while (in_period >= period) in_period -= period;
  return in_period < size ? in_period : period - 1 - in_period;
}

// Texels from the image's edge, in [-size, 2 size]; where it repeats in [0, 2 size]. Far away coordinates are first
// brought near, where they still are whole texels.
float ToTexels(float coordinate, int size, Wrap wrap) {
  if (wrap == Wrap::kClampToEdge) return std::clamp(coordinate, -1.0f, 2.0f) * float(size);
  const bool is_near = coordinate >= 0 && coordinate < 2;
  return (is_near ? coordinate : float(coordinate - 2 * std::floor(double(coordinate) / 2))) * float(size);
}

}  // namespace

RayMask::RayMask(const Material& material, const Texture& texture, int width, int height,
                 const std::vector<uint8_t>& rgba)
    : is_blend_(material.alpha_mode == AlphaMode::kBlend),
      alpha_cutoff_(material.alpha_cutoff),
      wrap_s_(texture.wrap_s),
      wrap_t_(texture.wrap_t),
      is_nearest_(texture.magnifies_to_nearest),
      width_(width),
      height_(height),
      alphas_(size_t(width) * height) {
  for (size_t i = 0; i < alphas_.size(); ++i) alphas_[i] = rgba[4 * i + 3];
}

float RayMask::AlphaAt(const glm::vec2& texcoord) const {
  const float x = ToTexels(texcoord.x, width_, wrap_s_);
  const float y = ToTexels(texcoord.y, height_, wrap_t_);
  if (is_nearest_) {
    return TexelAt(WrapTexel(Floor(x), width_, wrap_s_), WrapTexel(Floor(y), height_, wrap_t_));
  }
  const int left = Floor(x - 0.5f), top = Floor(y - 0.5f);
  const int x0 = WrapTexel(left, width_, wrap_s_), x1 = WrapTexel(left + 1, width_, wrap_s_);
  const int y0 = WrapTexel(top, height_, wrap_t_), y1 = WrapTexel(top + 1, height_, wrap_t_);
  const float u = x - 0.5f - float(left), v = y - 0.5f - float(top);
  return glm::mix(glm::mix(TexelAt(x0, y0), TexelAt(x1, y0), u), glm::mix(TexelAt(x0, y1), TexelAt(x1, y1), u), v);
}

bool RayMask::IsMaskedAway(const glm::vec2& texcoord, float alpha, const glm::vec3& place) const {
  const float cutoff = is_blend_ ? BlendThreshold(place) : alpha_cutoff_;
  return (alphas_.empty() ? alpha : alpha * AlphaAt(texcoord)) < cutoff;
}

absl::StatusOr<RayMask> MakeRayMask(const FlatScene& scene, const Material& material, const ImageDecoder& decoder) {
  if (material.base_color_texture.texture < 0) return RayMask(material);
  const Texture& texture = scene.textures[material.base_color_texture.texture];
  ASSIGN_OR_RETURN(const Rgba8Image image, decoder(scene.images[texture.image]));
  return RayMask(material, texture, image.width, image.height, image.texels);
}

}  // namespace halfshade
