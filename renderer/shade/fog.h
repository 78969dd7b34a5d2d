// A medium between eye and scene: what it scatters of each light toward the eye, over what it lets through.
//
// The view of each pixel is cut into kFogSteps parts that take equal shares of it; in each one point is asked for its
// visibility by the method of the request, as any other point without a normal is. Scattering is even in all directions
// and happens once; what a light sends is weakened on its way by the medium between its centre and the point. Closed
// forms along straight lines, exact for a density that falls exponentially with height; only the integral along the
// view is sampled. World axes, metres.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/texture.h"
#include "renderer/light/receivers.h"
#include "renderer/request.h"

namespace halfshade {

inline constexpr int kFogSteps = 16;

// The fog of one view. Outlives neither its receivers nor the context.
class FogView {
 public:
  // `pixels`: receivers that are pixels.
  static absl::StatusOr<FogView> Create(const DrawContext& draw, const Receivers& pixels, const RenderRequest& request);

  // One point a pixel, of step 0 to kFogSteps - 1; until the next call. `on_cpu`: also in memory.
  absl::StatusOr<Receivers> StepPoints(const DrawContext& draw, int step, bool on_cpu);
  // Adds what these points, the last that StepPoints gave, scatter of a light; visibility: red channel.
  absl::Status AddLight(const DrawContext& draw, const Receivers& points, const AreaLight& light,
                        const gl::Texture& visibility);
  // Over the frame, when all lights are added.
  absl::Status DrawOver(const DrawContext& draw, gl::Texture& frame);

 private:
  Receivers pixels_;
  const RenderRequest* request_ = nullptr;
  gl::Texture no_planes_;  // of points without a horizon
  gl::Texture points_;
  gl::Texture scattered_;
  CpuReceivers on_cpu_;
};

// Uniforms of shaders/shade/fog.glsl.
void SetFog(gl::Program& program, const Fog& fog);
// `height_ws` over the ground of the fog.
float HeightInFog(const Fog& fog, double height_ws);

}  // namespace halfshade
