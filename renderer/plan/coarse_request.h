// What a progressive render shows before the whole picture: the same with fewer pixels and a larger error. Pure; no GL.
#pragma once

#include <vector>

#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"

namespace halfshade {

// Requests to draw before `request`, in this order: a quarter of its size at an error of .03, half of it at .01 (a
// soft shadow map: of its texels a side), each by what of AUTO's methods is the soonest there, with one sample a pixel,
// no budget and no certificate. Of the first all of its data count; of the second none that the first or the whole have
// of the same method. One is left out where it is predicted to take over half of the whole's time, or where with
// max_latency it and the whole would not be in time. `request` is settled (SettleMethod), and is not changed by what
// comes before it.
std::vector<RenderRequest> PlanCoarseRequests(const FlatScene& scene, const Pose& pose, const RenderRequest& request);

}  // namespace halfshade
