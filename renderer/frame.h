// One frame on its way through the house.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "renderer/plan/frame_plan.h"
#include "renderer/prepare_light.h"
#include "renderer/renderer.h"
#include "renderer/seen_view.h"
#include "renderer/shade/shade.h"

namespace halfshade {

// What a report says before anything is drawn, but for the lights' skips.
RenderReport DescribePlan(const FramePlan& plan, const RenderRequest& request, const RegisteredMethod& method);

// UNIMPLEMENTED where an output is of what the method does not know.
absl::Status CheckOutputs(const RenderRequest& request, const RegisteredMethod& method);

// Renderer::Render on a context with these caches. `on_context`: the scene; its textures come as they are needed.
absl::StatusOr<RenderResult> DrawFrame(const DrawContext& draw, const LtcTextures& ltc, const std::string& scene_name,
                                       const FlatScene& scene, const RenderRequest& request,
                                       const ImageDecoder& decoder, SceneOnContext& on_context, LightCaches& caches,
                                       gl::ObjectCache<SeenView>& views);

}  // namespace halfshade
