// How a light emits, as shaders take it.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "renderer/request.h"

namespace halfshade {

struct Emitter {
  std::vector<std::string> defines;  // of light.frag and fog_light.frag
  glm::dvec3 emitted{0};             // radiance of a rectangle, intensity of a line or point
};

// Edges shorter than a millionth of the distance to the camera's target make a line or a point.
Emitter MakeEmitter(const AreaLight& light, const Camera& camera);

}  // namespace halfshade
