// How fast this machine draws, beside the one that the table of costs was made on.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/renderer.h"

namespace halfshade {

// Wall time of a small render on this renderer, as a multiple of its time on the table's machine (plan/cost_model.h),
// within 1/16 to 64: Machine::slowness. The least of five, some 25 ms in all. Leaves the render's scene forgotten.
absl::StatusOr<double> MeasureSlowness(Renderer& renderer);

}  // namespace halfshade
