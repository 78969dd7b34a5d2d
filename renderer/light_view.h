// What a light's centre sees of the receivers: the grid of a soft shadow map, drawn.
#pragma once

#include <absl/status/statusor.h>

#include <vector>

#include "renderer/light/receivers.h"
#include "renderer/plan/light_grid.h"
#include "renderer/prepare_light.h"
#include "renderer/shade/gbuffer.h"

namespace halfshade {

struct LightView {
  LightGrid grid;
  RenderRequest request;  // its camera is the light's, its size that of the map
  GBuffer gbuffer;
  std::vector<float> light_z;  // [light_map_size][light_map_size] metres, 0: nothing there
  bool casts = false;          // GridReceivers: nothing receives that does not cast

  // Lives as long as this.
  Receivers receivers() const { return {&gbuffer.planes, request.camera, request.width, request.height}; }
};

// Of the request's camera the target alone counts, which centres the ground. `light`: one-sided.
absl::StatusOr<LightView> DrawLightView(const DrawContext& draw, const LightSource& source, const AreaLight& light);

}  // namespace halfshade
