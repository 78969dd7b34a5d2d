#include "renderer/light/cpu_occluders.h"

#include <utility>

#include "renderer/status.h"

namespace halfshade {

absl::StatusOr<CpuOccluders> BuildCpuOccluders(const FlatScene& scene, const Pose& pose,
                                               const std::vector<uint32_t>& kept_meshes, const AreaLight& light,
                                               const ImageDecoder& decoder) {
  CpuOccluders occluders;
  KeptPlaces kept = FindKeptPlaces(scene, pose, kept_meshes, light);
  occluders.places = std::move(kept.places);
  occluders.triangles = BuildLightSpaceOccluders(scene, pose, light, kept.elsewhere);
  for (const MaskedOccluders& masked : occluders.triangles.masked) {
    ASSIGN_OR_RETURN(RayMask mask, MakeRayMask(scene, scene.materials[masked.material], decoder));
    occluders.masks.push_back(std::move(mask));
  }
  return occluders;
}

}  // namespace halfshade
