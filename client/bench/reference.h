// The truth that a case's errors are taken against, out of rays.
#pragma once

#include <absl/status/status.h>

#include <cstdint>

#include "client/bench/bench.h"

namespace halfshade::bench {

// Fills `result`'s mask, reference, its noise and its cost. The reference is the mean of two halves of `rays` / 2 rays
// a pixel with seeds of their own; of a Gaussian case it is GaussianLights.
absl::Status MeasureReference(Client& client, const Case& bench_case, const v1::Scene& scene, uint32_t rays,
                              CaseResult* result);

// One of the lights that stand for a bright middle.
struct WeighedPoint {
  double u = 0, v = 0;  // in edges of the light, from its centre
  double weight = 0;    // they sum to 1
};

// side x side points on a grid over 1.3129 times the light, weighed by a Gaussian cut at two deviations: what GAUSSIAN
// filters stand for (renderer/light/center_map), whose variance is the rectangle's. Pure. Source: Buades et al. 2015,
// Table 6 (41 a side).
std::vector<WeighedPoint> GaussianLights(int side);

}  // namespace halfshade::bench
