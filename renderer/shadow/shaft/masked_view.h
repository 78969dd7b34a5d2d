// A triangle with a mask as one receiver sees it on the light.
#pragma once

#include <glm/glm.hpp>

#include "renderer/scene/ray_mask.h"
#include "renderer/shadow/shaft/polygons.h"

namespace halfshade {

// Along the segment from the receiver to the light's point (x, y) the triangle's texture coordinates and alpha, of
// BLEND its place too, are linear forms of the segment's direction, over a common one (Moeller and Trumbore 1997, for
// all points at once): made once a triangle and receiver. Shaft space; float arithmetic without contraction, the same
// on every machine.
class MaskedView {
 public:
  MaskedView() = default;
  MaskedView(const MaskedTriangle& triangle, const RayMask& mask, const glm::vec3& receiver) : receiver_(receiver) {
    const glm::vec3 edge1 = triangle.corners[1] - triangle.corners[0];
    const glm::vec3 edge2 = triangle.corners[2] - triangle.corners[0];
    const glm::vec3 arm = receiver - triangle.corners[0];
    divisor_ = glm::cross(edge2, edge1);
    const glm::vec3 second = glm::cross(edge2, arm), third = glm::cross(arm, edge1);  // corners' weights
    const auto form = [&](const glm::vec3* corner, int k) {
      return divisor_ * corner[0][k] + second * (corner[1][k] - corner[0][k]) + third * (corner[2][k] - corner[0][k]);
    };
    for (int k = 0; k < 3; ++k) forms_[k] = form(triangle.mask_corners, k);
    if (!mask.is_blend()) return;
    for (int k = 0; k < 3; ++k) place_forms_[k] = form(triangle.blend_places, k);
  }

  // Whether the mask leaves nothing of the triangle where the segment to (x, y) meets its plane.
  bool IsMaskedAway(const RayMask& mask, float x, float y) const {
    const glm::vec3 direction = glm::vec3(x, y, 0) - receiver_;
    const float divisor = glm::dot(direction, divisor_);
    if (divisor == 0) return true;
    const auto along = [&](const glm::vec3& form) { return glm::dot(direction, form) / divisor; };
    const glm::vec2 texcoord(along(forms_[0]), along(forms_[1]));
    const float alpha = along(forms_[2]);
    if (!mask.is_blend()) return mask.IsMaskedAway(texcoord, alpha);
    return mask.IsMaskedAway(texcoord, alpha, {along(place_forms_[0]), along(place_forms_[1]), along(place_forms_[2])});
  }

 private:
  glm::vec3 receiver_{0}, divisor_{0};
  glm::vec3 forms_[3] = {glm::vec3(0), glm::vec3(0), glm::vec3(0)};
  glm::vec3 place_forms_[3];  // of BLEND; not set otherwise
};

}  // namespace halfshade
