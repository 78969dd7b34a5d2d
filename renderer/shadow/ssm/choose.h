// What SSM chooses where the request leaves it open. Pure.
#pragma once

#include "renderer/light/window.h"
#include "renderer/request.h"

namespace halfshade {

struct SsmChoice {
  int sub_lights = 1;  // along each edge
  int map_size = 256;  // patches a side
};

// From the light's widest footprint as a part of the occluders' window, L w_near / (u1 - u0): the wider, the more
// sub-lights (up to 4 x 4), and patches so many that a sub-light's footprint holds 16 (within 256..512;
// 512 where occluders cross the light's plane).
SsmChoice ChooseSsm(const SsmOptions& options, const AreaLight& light, const OccluderHull& hull);

}  // namespace halfshade
