// A mean over neighbours that stops where the surface does: what takes the noise out of a few rays a pixel. Pure.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "renderer/image/image.h"

namespace halfshade {

// What each pixel sees, [height][width]: points relative to any one origin, unit normals; a normal of 0: nothing.
struct Surfaces {
  std::vector<glm::vec3> points;
  std::vector<glm::vec3> normals;
};

// Of a [height][width][1] image the mean over (2 radius + 1)^2 pixels that are of one smooth surface with the middle
// one: normals within 26 degrees, points within 6 degrees of its plane. Where nothing is seen values stay. Cross
// bilateral filter (Eisemann and Durand 2004, Petschnigg et al. 2004) with steps for weights.
Image FilterAlongSurfaces(const Image& values, const Surfaces& surfaces, int radius);

}  // namespace halfshade
