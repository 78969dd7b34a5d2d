#include "renderer/light/cpu_occluders.h"

#include <utility>

#include "renderer/status.h"

namespace halfshade {

absl::StatusOr<CpuOccluders> BuildCpuOccluders(const FlatScene& scene, const Pose& pose, const AreaLight& light,
                                               const ImageDecoder& decoder) {
  CpuOccluders occluders;
  SharedMeshes found = FindSharedMeshes(scene, pose, light);
  occluders.shared = std::move(found.meshes);
  occluders.triangles = BuildLightSpaceOccluders(scene, found.rest, light, found.largest_coordinate_m);
  for (const MaskedOccluders& masked : occluders.triangles.masked) {
    ASSIGN_OR_RETURN(RayMask mask, MakeRayMask(scene, scene.materials[masked.material], decoder));
    occluders.masks.push_back(std::move(mask));
  }
  return occluders;
}

}  // namespace halfshade
