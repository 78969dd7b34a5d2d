// What a progressive render shows before the whole picture: the same with fewer pixels and a larger error. Pure; no GL.
#pragma once

#include <vector>

#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"

namespace halfshade {

// Requests to draw before `request`, in this order: a quarter of its size at an error of .03, half of it at .01 (a
// soft shadow map: of its texels a side), each by what AUTO would choose for that, with one sample a pixel, no budget
// and no certificate. A coarse one is left out where it is predicted to take over half of the whole's time: the first
// with its light data, the second without, which is the same. With max_latency it is left out too where it and the
// whole would not be in time. `request` is settled (SettleMethod), and is not changed by what comes before it.
std::vector<RenderRequest> PlanCoarseRequests(const FlatScene& scene, const Pose& pose, const RenderRequest& request);

}  // namespace halfshade
