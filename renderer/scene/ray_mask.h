// glTF's alphaModes MASK and BLEND for rays and samples: the twin on the CPU of shaders/common/mask.glsl. Immutable;
// any thread.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/renderer.h"
#include "renderer/scene/blend.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

class RayMask {
 public:
  // Without a texture: the vertices' alpha alone is compared, with the material's cutoff or, of BLEND, a threshold that
  // differs from place to place (blend.h).
  explicit RayMask(const Material& material)
      : is_blend_(material.alpha_mode == AlphaMode::kBlend), alpha_cutoff_(material.alpha_cutoff) {}
  // `rgba`: [height][width][4], the finest level, read as `texture` is magnified.
  RayMask(const Material& material, const Texture& texture, int width, int height, const std::vector<uint8_t>& rgba);

  bool is_blend() const { return is_blend_; }
  // `place`: of BLEND alone, BlendSpace::Place.
  bool IsMaskedAway(const glm::vec2& texcoord, float alpha, const glm::vec3& place = glm::vec3(0)) const;
  uint64_t SizeBytes() const { return alphas_.size(); }

 private:
  float TexelAt(int x, int y) const { return float(alphas_[size_t(y) * width_ + x]) / 255; }
  float AlphaAt(const glm::vec2& texcoord) const;

  bool is_blend_ = false;
  float alpha_cutoff_ = 0;
  Wrap wrap_s_ = Wrap::kRepeat, wrap_t_ = Wrap::kRepeat;
  bool is_nearest_ = false;
  int width_ = 0, height_ = 0;
  std::vector<uint8_t> alphas_;  // empty: no texture
};

// The mask of a material in `scene`: its image is decoded here, and the decoder's errors come back.
absl::StatusOr<RayMask> MakeRayMask(const FlatScene& scene, const Material& material, const ImageDecoder& decoder);

}  // namespace halfshade
