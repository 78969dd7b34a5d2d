// Full-screen passes in bands, so that none is predicted over the submission bound.
#pragma once

#include <absl/status/status.h>

#include "renderer/gl/draw_context.h"

namespace halfshade {

// Draws one triangle over the bound framebuffer of width x height with the program in use, in bands of rows, charging
// the pacer with nanoseconds_per_pixel for each. Blending and other state are the caller's.
absl::Status DrawFullscreen(const DrawContext& draw, int width, int height, double nanoseconds_per_pixel);

}  // namespace halfshade
