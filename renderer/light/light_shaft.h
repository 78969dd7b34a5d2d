// The convex hull of a light and some receivers, from outside: half-spaces that hold it. What misses it hides nothing
// of the light from any of them.
//
// Any space with straight lines. Its sides are those of the box around everything, and along each axis the edges of the
// hull's shadow; some of the hull's own sides are oblique to all three, so a box that misses the hull may not be seen
// to. Pure. Source: Haines and Wallace 1991, "Shaft Culling for Efficient Ray-Cast Radiosity", of boxes.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/flat_scene.h"

namespace halfshade {

class LightShaft {
 public:
  // Holds whatever is within 2^-17 of the largest coordinate (or of 1) of the hull: rounding of segments in floats.
  // Requires a box that is not empty.
  LightShaft(const std::array<glm::dvec3, 4>& light, const Box3d& receivers);

  // What has no point with normal . p >= least hides nothing, either.
  void CutBelow(const glm::dvec3& normal, double least) { sides_.push_back({-normal, -least}); }

  // No point of the box is in the hull; false when in doubt.
  bool Misses(const Box3f& box) const;

 private:
  struct Side {
    glm::dvec3 normal;  // outward
    double most;        // of normal . p in the hull
  };
  std::vector<Side> sides_;
};

}  // namespace halfshade
