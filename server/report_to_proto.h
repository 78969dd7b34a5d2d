// Plain reports to the wire's.
#pragma once

#include "halfshade/v1/report.pb.h"
#include "renderer/report.h"

namespace halfshade {

// Method, options, shares, passes, caches and the renderer's timings. Queue, load, encode, totals and outputs are the
// caller's.
v1::RenderReport ToProto(const RenderReport& report);

}  // namespace halfshade
