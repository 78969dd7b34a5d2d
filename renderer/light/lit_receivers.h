// Receivers in the order that rays are traced in, and those that need none. No GL.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "renderer/light/cpu_receivers.h"
#include "renderer/request.h"
#include "renderer/scene/ray_scene.h"

namespace halfshade {

// All that receive; pixels in tiles of 16 x 16, whose rays share nodes of the hierarchy.
std::vector<uint32_t> ReceiversInTiles(const CpuReceivers& receivers);

// Trace lengths (ray_scene.h) by which the receiver's plane may be off: it came in floats, 4 ulps of the distance to
// the eye that it is told from.
double PlaneError(const RayScene& scene, const CpuReceivers& receivers, const CpuReceiver& receiver);

// One a receiver: 1 where nothing stands between the light and the 256 of `order`, in its order, that it is one of; no
// ray that is traced there would meet anything. `stop` as ParallelFor.
absl::StatusOr<std::vector<uint8_t>> FindLit(const RayScene& scene, const AreaLight& light,
                                             const CpuReceivers& receivers, const std::vector<uint32_t>& order,
                                             const std::function<absl::Status()>& stop, int threads);

}  // namespace halfshade
