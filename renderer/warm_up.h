// Draws a tiny scene once with every method, because shaders compile at their first draw.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/renderer.h"

namespace halfshade {

// The renderer's decoder must take the scene's one image: WarmUpTexel does.
absl::Status WarmUp(Renderer& renderer);
absl::StatusOr<Rgba8Image> WarmUpTexel(const EncodedImage& image);

}  // namespace halfshade
