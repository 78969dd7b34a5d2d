// Microfacet reflection in double, for the fit and its tests: GGX normals, height-correlated Smith shadowing, Fresnel
// left out (1). Surface frame: z the normal; directions are unit and point away from the surface.
//
// Sources: Walter et al. 2007 (distribution), Heitz 2014 (height-correlated shadowing), Heitz 2018 (visible normals).
#pragma once

#include <glm/glm.hpp>

namespace halfshade {

// The BRDF times the cosine of `light`, 1/sr. 0 where either direction is at or below the surface. alpha in (0,1].
double GgxTimesCosine(const glm::dvec3& view, const glm::dvec3& light, double alpha);

// A direction drawn in proportion to the normals that `view` sees, from a point of the unit square.
struct GgxSample {
  glm::dvec3 light{0};
  double weight = 0;         // GgxTimesCosine / density, in [0,1]: its mean is the albedo; 0 below the surface
  double density = 0;        // of `light`, 1/sr
  double fresnel_share = 0;  // (1 - cosine between view and half vector)^5: Schlick's factor of 1 - F0
};
GgxSample SampleGgx(const glm::dvec3& view, double alpha, const glm::dvec2& unit);

// The density with which SampleGgx draws `light`.
double GgxDensity(const glm::dvec3& view, const glm::dvec3& light, double alpha);

}  // namespace halfshade
