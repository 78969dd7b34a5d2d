// The grid of a soft shadow map: what a light's centre sees of the receivers, as a camera. Pure; no GL.
#pragma once

#include <glm/glm.hpp>

#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"

namespace halfshade {

// Texel (i, j) of size x size looks from the light's centre along (u, v, 1) in its frame,
//   u = u0 + (i + 1/2) / size (u1 - u0),  v = v0 + (j + 1/2) / size (v1 - v0).
struct LightGrid {
  glm::dmat4 light_from_world{1};
  glm::dvec4 window{0};  // u0, v0, u1, v1; square
};

// What receives in the map: what does not cast, where there is any such (the ground is); else all that receives. So the
// map lies on what a shadow falls on, as in Atty et al. 2006, and not on the tops of what throws it.
Pose GridReceivers(const Pose& pose, const RenderRequest& request);

// The window holds what these receivers and the widest shadows of the occluders have in common: outside it, everything
// is lit but for its own horizon. Slopes are cut at 8. `light`: one-sided.
LightGrid PlanLightGrid(const FlatScene& scene, const Pose& occluders, const Pose& receivers,
                        const RenderRequest& request, const AreaLight& light);

// The camera whose pixel (i, j) of a square picture is that texel; it keeps the request's target, which centres the
// ground.
Camera CameraOf(const LightGrid& grid, const AreaLight& light, const RenderRequest& request);

}  // namespace halfshade
