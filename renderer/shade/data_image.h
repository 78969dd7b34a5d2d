// The outputs that show geometry and materials instead of light, from a G-buffer.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/gl/draw_context.h"
#include "renderer/image/image.h"
#include "renderer/request.h"
#include "renderer/shade/gbuffer.h"

namespace halfshade {

// kDepth, kNormal, kAlbedo, kObjectId or kPosition (asserted) in the form that OutputKind states. Waits for the
// drawing.
//
// Depth and position are the meeting of the pixel's ray with the plane of the triangle seen through it, in double, and
// rounded once: off by a few float ulps of the distances from the eye to surface and mesh origin over the cosine at
// which the plane is seen, and not at all by the depth buffer or a far origin of the world. Normals and colours come
// from half floats: directions within 1e-3 rad, colours within 2^-10 of themselves.
// Errors: the stop check's, asked every few rows.
absl::StatusOr<Image> ReadDataImage(const DrawContext& draw, OutputKind kind, const GBuffer& gbuffer,
                                    const Camera& camera);

}  // namespace halfshade
