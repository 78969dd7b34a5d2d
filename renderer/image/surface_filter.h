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

// Of one smooth surface: normals within 26 degrees, b within 6 degrees of the plane of a. Unit normals.
inline bool AreOneSurface(const glm::vec3& normal_a, const glm::vec3& a, const glm::vec3& normal_b,
                          const glm::vec3& b) {
  constexpr float kLeastCosine = 0.9f, kMostSlope = 0.1f;
  if (!(glm::dot(normal_a, normal_b) >= kLeastCosine)) return false;
  const glm::vec3 arm = b - a;
  const float height = glm::dot(arm, normal_a);
  return height * height <= kMostSlope * kMostSlope * glm::dot(arm, arm);
}

// Of a [height][width][1] image the mean over (2 radius + 1)^2 pixels that are of one smooth surface with the middle
// one. Where nothing is seen values stay. Cross bilateral filter (Eisemann and Durand 2004, Petschnigg et al. 2004)
// with steps for weights.
Image FilterAlongSurfaces(const Image& values, const Surfaces& surfaces, int radius);

}  // namespace halfshade
