// One render for the bench, and its picture.
#pragma once

#include <absl/status/statusor.h>

#include "client/bench/bench.h"

namespace halfshade::bench {

struct Shot {
  v1::RenderReport report;
  Image visibility;  // of the first light
};

// VISIBILITY of the case's lights, as raw floats.
v1::RenderRequest VisibilityRequest(const Case& bench_case, const v1::Method& method, v1::CacheMode cache);
v1::RenderRequest VisibilityRequest(const Case& bench_case, const Setting& setting, v1::CacheMode cache);

absl::StatusOr<Shot> Shoot(Client& client, const v1::RenderRequest& request);

// All channels of a raw float image. INTERNAL where its bytes do not fit its size.
absl::StatusOr<Image> RawImage(const v1::OutputImage& raw);
absl::StatusOr<Image> FirstChannel(const v1::OutputImage& raw);

}  // namespace halfshade::bench
