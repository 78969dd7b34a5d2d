// Plain reports to the wire's, and what both call kinds and encodings.
#pragma once

#include <optional>
#include <string>

#include "halfshade/v1/render.pb.h"
#include "renderer/report.h"
#include "renderer/request.h"
#include "server/output_format.h"

namespace halfshade {

// Method, options, shares, passes, caches and the renderer's timings. Queue, load, encode, totals and outputs are the
// caller's.
v1::RenderReport ToProto(const RenderReport& report);

v1::OutputKind ToProto(OutputKind kind);
v1::Encoding ToProto(Encoding encoding);
// UNSPECIFIED is FRAME, and PNG. Nothing for a number that the wire has no name for.
std::optional<OutputKind> FromProto(v1::OutputKind kind);
std::optional<Encoding> FromProto(v1::Encoding encoding);
// "FRAME", "EXR_HALF".
std::string ShortName(v1::OutputKind kind);
std::string ShortName(v1::Encoding encoding);

}  // namespace halfshade
