// The way out of every method: sums become visibility in [0,1] and the horizon is applied.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/texture.h"
#include "renderer/light/receivers.h"
#include "renderer/request.h"
#include "renderer/shadow/shadow_method.h"

namespace halfshade {

// RG32F [height][width]: v = share clamp(1 - sum/full), and the share of the light's area above the receiver's
// plane (0: it faces away or stands behind the light; -1: nothing is drawn there, or it does not receive: v = 1).
// `occlusion` null: nothing hides the light, v is the share. `penumbra_width`, if not null, becomes R32F: metres on the
// receiver, eq. 1 of Buades et al. 2015 over the light's longer edge; 0 where less than 1/512 of the light above the
// plane is hidden, or seen. `others`, if not null: the result for other occluders at the same receivers; v is of both,
// as if they hid independent parts of the light.
absl::StatusOr<gl::Texture> FinishVisibility(const DrawContext& draw, const OcclusionSum* occlusion,
                                             const Receivers& receivers, const AreaLight& light,
                                             gl::Texture* penumbra_width = nullptr,
                                             const gl::Texture* others = nullptr);

// The same v in memory, for sums in memory (null: nothing hides the light) and receivers in memory; no GL.
std::vector<float> FinishVisibilityOnCpu(const OcclusionSum* occlusion, const CpuReceivers& receivers,
                                         const AreaLight& light);

// The largest sum / full sum before it is clamped. Waits for the drawing.
absl::StatusOr<double> LargestFraction(const OcclusionSum& occlusion, size_t receivers);

}  // namespace halfshade
