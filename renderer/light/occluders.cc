#include "renderer/light/occluders.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/math/light_frame.h"

namespace halfshade {

LightSpaceOccluders BuildLightSpaceOccluders(const FlatScene& scene, const Pose& pose, const AreaLight& light) {
  const glm::dmat4 light_from_world = LightFromWorld(MakeLightFrame(light));
  LightSpaceOccluders occluders;
  double largest_coordinate = 0;
  double smallest_z = std::numeric_limits<double>::infinity();
  bool crosses_plane = false;
  std::vector<uint32_t> crossing;  // first indices of triangles that cross the light's plane
  for (const Instance& instance : pose.instances) {
    if (!instance.casts) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    const glm::dmat4 light_from_mesh = light_from_world * instance.world_from_mesh;
    const uint32_t first_vertex = uint32_t(occluders.positions.size());
    for (uint32_t i = 0; i < mesh.vertex_count; ++i) {
      const glm::dvec3 point(light_from_mesh * glm::dvec4(scene.positions[mesh.first_vertex + i], 1));
      occluders.positions.emplace_back(point);
    }
    for (uint32_t i = 0; i < mesh.index_count; i += 3) {
      const uint32_t* corner = &scene.indices[mesh.first_index + i];
      float low = std::numeric_limits<float>::infinity();
      float high = -low;
      for (int k = 0; k < 3; ++k) {
        const glm::vec3& p = occluders.positions[first_vertex + corner[k]];
        low = std::min(low, p.z);
        high = std::max(high, p.z);
      }
      if (high <= 0) continue;
      for (int k = 0; k < 3; ++k) {
        const glm::vec3 p = glm::abs(occluders.positions[first_vertex + corner[k]]);
        largest_coordinate = std::max<double>(largest_coordinate, std::max({p.x, p.y, p.z}));
        occluders.indices.push_back(first_vertex + corner[k]);
      }
      if (low <= 0) {
        crosses_plane = true;
      } else {
        smallest_z = std::min<double>(smallest_z, low);
      }
    }
  }
  const double floor = std::ldexp(largest_coordinate, -20);
  double z_near = crosses_plane ? floor : smallest_z * (1 - std::ldexp(1.0, -10));
  if (occluders.indices.empty()) z_near = 1;
  occluders.hull = OccluderHull(light.width_m / 2, light.height_m / 2, z_near);
  for (size_t i = 0; i < occluders.indices.size(); i += 3) {
    const uint32_t* corner = &occluders.indices[i];
    occluders.hull.AddTriangle(occluders.positions[corner[0]], occluders.positions[corner[1]],
                               occluders.positions[corner[2]]);
  }
  return occluders;
}

}  // namespace halfshade
