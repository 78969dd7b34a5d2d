// How much of a light each receiver sees, by rays: the ground truth of every other method, and the tracer of what they
// leave undecided.
//
// Points on the light: one Owen-scrambled Sobol sequence a seed, moved by a digital shift (exclusive or) that each
// receiver's hash gives: every receiver has a stratified sequence of its own, and sixteen neighbours on the light stay
// neighbours, so a packet of rays is a narrow beam. The receiver's own plane is no occluder (ray_scene.h); of the light
// what stands above that plane is sampled and weighed by its exact share, so a lone plane has no noise. Where nothing
// is between a tile of receivers and the light (light_shaft.h), no ray is traced, to the same numbers. No GL.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <vector>

#include "renderer/light/cpu_receivers.h"
#include "renderer/request.h"
#include "renderer/scene/ray_scene.h"

namespace halfshade {

struct TraceOptions {
  int rays = 256;             // at each receiver; the most, where adaptive
  bool is_adaptive = false;   // 16, 64, 256, ... rays, at each receiver until
  double stop_error = 0.005;  // ExpectedTraceError of its visibility is this, or
  double mean_error = 0;      // above 0: until this is expected of all that are shadowed; the largest errors go on
  uint32_t seed = 0;
  bool skips_lit = true;  // leave out the rays of lit tiles
  int threads = 0;        // at most; 0: as many as this process may use
};

struct TracedLight {
  // One a receiver.
  std::vector<float> visibility;  // seen share of the light's area; 1 where nothing receives
  std::vector<float> hidden;      // hidden fraction, in [0,1], of the part of the light above the receiver's plane
  std::vector<float> errors;      // expected |error| of it, 0 where 16 rays or more agree
  uint64_t rays = 0;              // traced
  int most_rays = 0;              // at one receiver
  uint64_t lit = 0;               // receivers of tiles that nothing stands between and the light: without rays
};

// The same numbers whatever the threads. `stop` is asked on the calling thread about every 10 ms; its error comes back.
absl::StatusOr<TracedLight> TraceLight(const RayScene& scene, const AreaLight& light, const CpuReceivers& receivers,
                                       const TraceOptions& options, const std::function<absl::Status()>& stop);

// Expected |error| of a visibility that `rays` stratified rays put at visible / above: .7 sqrt(v (1 - v)) rays^-.75,
// the rate of scrambled nets on a region with an edge; with one ray more on each side, so that agreement is no proof.
// The factor was measured: .5 for one straight edge, 1 for clutter of leaves.
double ExpectedTraceError(int visible, int above, int rays);

}  // namespace halfshade
