// A tiny scene, drawn once with every method, because shaders compile at their first draw; and later, to see whether
// the context still draws.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/renderer.h"

namespace halfshade {

// The renderer's decoder must take the scene's one image: WarmUpTexel does.
absl::Status WarmUp(Renderer& renderer);
// One small picture of it by one method: the same each time.
absl::StatusOr<Image> DrawCanary(Renderer& renderer);
absl::StatusOr<Rgba8Image> WarmUpTexel(const EncodedImage& image);

}  // namespace halfshade
