// SOFT_SHADOW_MAP: what a light's own view sees of the light, by any method.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/image/image.h"
#include "renderer/plan/light_grid.h"
#include "renderer/prepare_light.h"

namespace halfshade {

struct SoftShadowMap {
  Image image;  // OutputKind::kSoftShadowMap
  LightGrid grid;
};

// The receivers, rasterised from the light's centre, pass through the same door as pixels; of the request's camera the
// target alone counts, which centres the ground. `data`: the light's, or null: it is prepared where the plan computes.
absl::StatusOr<SoftShadowMap> DrawSoftShadowMap(const DrawContext& draw, const LightSource& source,
                                                const LightPlan& plan, gl::ObjectCache<LightData>::Pointer data,
                                                LightCaches& caches, RenderReport& report);

}  // namespace halfshade
