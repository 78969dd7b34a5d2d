// Draws a tiny scene once with every method, because shaders compile at their first draw.
#pragma once

#include <absl/status/status.h>

#include "renderer/renderer.h"

namespace halfshade {

absl::Status WarmUp(Renderer& renderer);

}  // namespace halfshade
