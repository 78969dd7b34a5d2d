// Visibility from points: the story of a call without a camera.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/prepare_light.h"
#include "renderer/renderer.h"

namespace halfshade {

// Renderer::QueryVisibility on a context with these caches. `on_context`: the scene, for methods that draw maps; else
// null.
absl::StatusOr<QueryResult> QueryLights(const DrawContext& draw, const std::string& scene_name, const FlatScene& scene,
                                        const RenderRequest& request, const QueryPoints& points,
                                        SceneOnContext* on_context, const ImageDecoder& decoder, LightCaches& caches);

}  // namespace halfshade
