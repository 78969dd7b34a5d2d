// SOFT_SHADOW_MAP: what a light's own view sees of the light, by any method.
#pragma once

#include <absl/status/statusor.h>

#include <vector>

#include "renderer/image/image.h"
#include "renderer/light_layers.h"
#include "renderer/plan/light_grid.h"
#include "renderer/prepare_light.h"

namespace halfshade {

struct SoftShadowMap {
  Image image;  // OutputKind::kSoftShadowMap
  LightGrid grid;
};

// The receivers, rasterised from the light's centre, pass through the same door as pixels; of the request's camera the
// target alone counts, which centres the ground. `layers`: the light's, or none: they are prepared where the plan
// computes.
absl::StatusOr<SoftShadowMap> DrawSoftShadowMap(const DrawContext& draw, const LightSource& source,
                                                const MovedApart* apart, const LightPlan& plan,
                                                std::vector<LightLayer> layers, LightCaches& caches,
                                                RenderReport& report);

}  // namespace halfshade
