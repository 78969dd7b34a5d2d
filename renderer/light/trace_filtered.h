// How much of a light each pixel sees, by few rays that neighbours share: for coarse errors.
//
// Sixteen pixels of a block of 4 x 4 have each other part of one set of stratified points on the light, the same in
// every block (interleaved sampling, Keller and Heidrich 2001). So any 4 x 4 pixels together have the whole set, and
// their mean is as good as that many rays of one pixel; it is taken with weights 1/2 1 1 1 1/2 along both axes, over
// what is of one surface with the pixel (renderer/image/surface_filter.h), and kept within what the pixel's own rays
// allow. Their error falls as of stratified rays (trace_light.h) that are sixteen times as many, down to what the mean
// blurs. A packet has one ray of each pixel of a block. Where all first rays of a block and the eight around agree, no
// more are traced. No GL.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "renderer/light/cpu_receivers.h"
#include "renderer/request.h"
#include "renderer/scene/ray_scene.h"

namespace halfshade {

struct FilteredTraceOptions {
  int rays = 4;  // at each pixel, 1 or more
  uint32_t seed = 0;
  int threads = 0;  // at most; 0: as many as this process may use
};

struct FilteredLight {
  // One a pixel.
  std::vector<float> hidden;  // hidden fraction, in [0,1], of the part of the light above the pixel's plane
  std::vector<float> errors;  // expected |error| of it, noise and blur; not independent from pixel to pixel
  uint64_t rays = 0;          // traced
  uint64_t lit = 0;           // pixels of tiles that nothing stands between and the light: without rays
};

// The same numbers whatever the threads. Requires pixels (not points) and a light with an extent. `stop` as TraceLight.
absl::StatusOr<FilteredLight> TraceFiltered(const RayScene& scene, const AreaLight& light, const CpuReceivers& pixels,
                                            const FilteredTraceOptions& options,
                                            const std::function<absl::Status()>& stop);

}  // namespace halfshade
