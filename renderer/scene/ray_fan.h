// Segments from one point to up to sixteen others at a time: one packet of Embree's, filled once.
//
// Trace space (ray_scene.h). The inner loop of everything that traces: arrays in place, no copies.
#pragma once

#include <embree3/rtcore.h>

#include <glm/glm.hpp>

#include "renderer/scene/ray_scene.h"

namespace halfshade {

class RayFan {
 public:
  static constexpr int kSegments = 16;

  // From `origin`. `normal`: of the tangent plane there, or 0: none. A triangle with no corner above it cannot stand
  // between the origin and anything above, and is left out: with it the receiver's own triangle and those beside it in
  // one plane. So is one in whose own plane the origin stands, to the same measure: seen edge-on, or lain upon, as
  // where a pixel falls on the fold of two facets. So no offset is needed, and contacts don't leak. `error`: by which
  // origin and plane may be off, beyond the 4 ulps of their coordinates that are always allowed for. `scene` outlives
  // the fan.
  RayFan(const RayScene& scene, const glm::vec3& origin, const glm::vec3& normal, float error);

  // Segment i ends at origin + (direction_x[i], direction_y[i], direction_z[i]). Set all sixteen, none of length 0.
  float* direction_x() { return rays_.dir_x; }
  float* direction_y() { return rays_.dir_y; }
  float* direction_z() { return rays_.dir_z; }
  // -1: trace it, 0: don't. At first all are -1.
  int* is_wanted() { return is_wanted_; }

  // How many of the wanted segments meet a triangle.
  int CountOccluded();

 private:
  // What the filter is handed back by Embree.
  struct Context {
    RTCIntersectContext embree;  // first
    glm::vec3 origin, normal;
    float error;
  };
  friend void LeaveOutWhatHidesNothing(const RTCFilterFunctionNArguments* args);

  RTCSceneTy* scene_;
  Context context_;
  RTCRay16 rays_;
  alignas(64) int is_wanted_[kSegments];
};

// The filter that RayScene gives to Embree.
void LeaveOutWhatHidesNothing(const RTCFilterFunctionNArguments* args);

}  // namespace halfshade
