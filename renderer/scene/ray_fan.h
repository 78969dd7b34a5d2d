// Up to sixteen segments at a time, from one point (RayFan) or each from its own (RayBundle): one packet of Embree's,
// filled once.
//
// Trace space (ray_scene.h). The inner loop of everything that traces: arrays in place, no copies.
#pragma once

#include <embree3/rtcore.h>

#include <glm/glm.hpp>

#include "renderer/scene/ray_scene.h"

namespace halfshade {

// What a segment leaves out: a triangle with no corner above `normal`'s plane (0: none) cannot stand between the point
// and anything above. So the receiver's own triangle and those beside it in one plane go. So does one in whose own
// plane the point stands, to the same measure: seen edge-on, or lain upon, as where a pixel falls on the fold of two
// facets. So no offset is needed, and contacts don't leak. `error`: by which point and plane may be off, beyond the 4
// ulps of their coordinates that are always allowed for.
struct RayOrigin {
  glm::vec3 point{0}, normal{0};
  float error = 0;
};

// `scene` outlives it.
class RayPacket {
 public:
  static constexpr int kSegments = 16;
  RayPacket(const RayPacket&) = delete;
  RayPacket& operator=(const RayPacket&) = delete;

  // Segment i ends at its origin + (direction_x[i], direction_y[i], direction_z[i]). Set all that are wanted, none of
  // length 0.
  float* direction_x() { return rays_.dir_x; }
  float* direction_y() { return rays_.dir_y; }
  float* direction_z() { return rays_.dir_z; }
  // -1: trace it, 0: don't. At first all are -1.
  int* is_wanted() { return is_wanted_; }

 protected:
  explicit RayPacket(const RayScene& scene);
  ~RayPacket() = default;
  void SetOrigin(int segment, const RayOrigin& origin, unsigned id);
  // Sets the rays' ends and traces what is wanted.
  void Trace();

  // What the filter is handed back by Embree.
  struct Context {
    RTCIntersectContext embree;    // first
    RayOrigin origins[kSegments];  // by the ray's id; errors with those 4 ulps
  };
  friend void LeaveOutWhatHidesNothing(const RTCFilterFunctionNArguments* args);

  RTCSceneTy* scene_;
  Context context_;
  RTCRay16 rays_;
  alignas(64) int is_wanted_[kSegments];
};

class RayFan : public RayPacket {
 public:
  RayFan(const RayScene& scene, const RayOrigin& origin);
  // How many of the wanted segments meet a triangle. All sixteen directions are set, of about one length.
  int CountOccluded();
};

class RayBundle : public RayPacket {
 public:
  explicit RayBundle(const RayScene& scene) : RayPacket(scene) {}
  // Of each segment that is wanted.
  void SetOrigin(int segment, const RayOrigin& origin) { RayPacket::SetOrigin(segment, origin, unsigned(segment)); }
  // Bit per segment: it is wanted and meets a triangle.
  uint32_t FindOccluded();
};

// The filter that RayScene gives to Embree.
void LeaveOutWhatHidesNothing(const RTCFilterFunctionNArguments* args);

}  // namespace halfshade
