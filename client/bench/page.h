// The bench's results as one self-contained HTML page: plots of error against time, pictures, tables. Pure.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "client/bench/tables.h"

namespace halfshade::bench {

// Per case a log-log plot of shadow cost against mae_shadowed with the Pareto front drawn, the frame, and for each
// method the difference image of its worst setting; then the curves; failed settings listed. INTERNAL where a picture
// cannot be encoded.
absl::StatusOr<std::string> ToHtml(const Results& results);

}  // namespace halfshade::bench
