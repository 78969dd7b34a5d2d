// The light's frame: origin at its centre, x and y along its edges, +z its normal. Metres.
#pragma once

#include <glm/glm.hpp>

#include "renderer/request.h"

namespace halfshade {

struct LightFrame {
  glm::dvec3 origin_ws{0};
  glm::dmat3 light_from_world_rotation{1};
};

LightFrame MakeLightFrame(const AreaLight& light);

// The light that shines from the other side of this one: turned about its v axis by half a turn.
AreaLight OtherSide(const AreaLight& light);

// The subtraction comes first: what is left has the precision of the distance, not of the world.
glm::dvec3 PointToLight(const LightFrame& frame, const glm::dvec3& point_ws);

// light_from_world with its translation in double. Multiply it with other double matrices before rounding.
glm::dmat4 LightFromWorld(const LightFrame& frame);

}  // namespace halfshade
