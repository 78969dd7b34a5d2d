// A soft shadow map that receivers of any camera look their visibility up in: projected from the light's centre, with
// bilinear filtering between texels of the receiver's own surface (Atty et al. 2006, 3.1).
#pragma once

#include <absl/status/statusor.h>

#include <span>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/texture.h"
#include "renderer/light/receivers.h"
#include "renderer/request.h"

namespace halfshade {

struct ProjectedMap {
  gl::Texture texels;  // RG32F: hidden fraction of the light above the receiver's plane, w; 0 0: no receiver
  glm::dvec4 window{0};
  bool casts = false;  // ReceiverMap::casts
};

// `hidden`: in [0, 1], one a texel of the receiver map.
absl::StatusOr<ProjectedMap> MakeProjectedMap(const gl::Context& context, const ReceiverMap& receivers,
                                              std::span<const float> hidden);

// R32F [height][width]: the hidden fraction. Of what is no surface of the map: nothing is hidden from what stands
// nearer to the light (occluders receive no shadow, as in the paper) or outside the window; what stands further gets
// the shadow of the surface before it, or that surface's own where it casts: 1.
absl::StatusOr<gl::Texture> Project(const DrawContext& draw, const ProjectedMap& map, const AreaLight& light,
                                    const Receivers& receivers);

}  // namespace halfshade
