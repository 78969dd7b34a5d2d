// The occluders of one light in memory, masks included, for methods that resolve on the CPU. No GL.
#pragma once

#include <absl/status/statusor.h>

#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "renderer/light/occluders.h"
#include "renderer/light/shared_meshes.h"
#include "renderer/scene/mesh_levels.h"
#include "renderer/scene/ray_mask.h"

namespace halfshade {

struct CpuOccluders {
  LightSpaceOccluders triangles;             // of what is not shared, the hull's z_near() of all
  std::vector<RayMask> masks;                // one for each of triangles.masked
  std::shared_ptr<const MeshLevels> levels;  // null unless needed
  std::vector<SharedMesh> shared;
};

// Decodes the masks' images; the decoder's errors come back.
absl::StatusOr<CpuOccluders> BuildCpuOccluders(const FlatScene& scene, const Pose& pose, const AreaLight& light,
                                               const ImageDecoder& decoder);

}  // namespace halfshade
