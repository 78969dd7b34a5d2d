// The occluders of one light in memory, masks included, for methods that resolve on the CPU. No GL.
#pragma once

#include <absl/status/statusor.h>

#include <glm/glm.hpp>
#include <vector>

#include "renderer/light/kept_meshes.h"
#include "renderer/light/occluders.h"
#include "renderer/scene/ray_mask.h"

namespace halfshade {

struct CpuOccluders {
  LightSpaceOccluders triangles;  // of what is not kept, the hull's z_near() of all
  std::vector<RayMask> masks;     // one for each of triangles.masked
  std::vector<KeptPlace> places;  // of kept meshes
};

// Decodes the masks' images; the decoder's errors come back. `kept_meshes`: FindKeptMeshes of the scene.
absl::StatusOr<CpuOccluders> BuildCpuOccluders(const FlatScene& scene, const Pose& pose,
                                               const std::vector<uint32_t>& kept_meshes, const AreaLight& light,
                                               const ImageDecoder& decoder);

}  // namespace halfshade
