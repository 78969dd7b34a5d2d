// Attenuation functions in which each sample stands for its stratum of the light: what the light's edges sweep in a
// stretch of depth, a ramp, where the sample alone makes a step.
//
// An edge that hides a sample at s from depth d_e of a ray on, and itself stands at depth d_p > d_e, is seen at depth d
// at the light coordinate l(d) = s.n (d_p - d_e) / (d_p - d) across the edge (n its normal in the map): along the ray
// it moves over the light, and over the sample's stratum while l is within the stratum's extent across the edge. n is
// told from which texels around the crossing hide the ray. Surfaces on the ray (EventKind::kTop) stay steps: a surface
// is where it is for the whole stratum. Source: ours, after SSM's light coordinate (Atty et al. 2006, 3.3). Pure; no
// GL.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <vector>

#include "renderer/shadow/pdsm/attenuation.h"
#include "renderer/shadow/pdsm/event_builder.h"
#include "renderer/shadow/pdsm/pdsm_grid.h"

namespace halfshade::pdsm {

// A part of the light, metres; its sample is its middle. (A sample beside it, near one of the light's axes, would meet
// only few of the edges that sweep the stratum.)
struct Stratum {
  glm::dvec2 middle{0}, half{0};
};
// k equal ones, a power of two; as square as halving allows, of a line along it.
std::vector<Stratum> Strata(const glm::dvec2& half_edges, int k);

// A change of a function's slope, or, where run is 0, of its value, from `depth` on (toward 0). Slopes are per depth
// that falls.
struct SlopeEvent {
  uint32_t column = 0;
  float depth = 0;
  float slope = 0;
  float step = 0;
};

// The events of one edge at one ray, in shares of one sample, for depths from 1 to 0. `across`: s.n; `low`, `high`: the
// stratum's extent along n; sign: +1 hides. Appends at most kRampPieces + 1.
inline constexpr int kRampPieces = 4;
struct Ramp {
  double occluder_depth = 0, depth = 0;
  double behind_depth = 0;  // of the surface behind the edge: from there on it decides, for all of the stratum
  double across = 0;
  double low = 0, high = 0;
  double sign = 1;
};
void AppendRamp(const Ramp& ramp, uint32_t column, std::vector<SlopeEvent>* events);

class SoftEventBuilder {
 public:
  // Edges that hide a sample only beyond infinity (depth below 0) may hide its stratum before: paths go on to here.
  static constexpr float kFarDepth = -1;
  static constexpr uint64_t kMaxEvents = 64ull << 20;
  SoftEventBuilder(const Grid& grid, uint64_t max_events = kMaxEvents);
  ~SoftEventBuilder();

  // As EventBuilder's.
  absl::Status Add(const SampleMap& map, const Stratum& stratum);
  absl::StatusOr<EventBuilder::Result> Finish(const Finishing& finishing);

 private:
  struct Rows;
  const Grid grid_;
  const uint64_t max_events_;
  int maps_ = 0;
  std::unique_ptr<Rows> rows_;
};

}  // namespace halfshade::pdsm
