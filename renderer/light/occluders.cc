#include "renderer/light/occluders.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/math/light_frame.h"
#include "renderer/scene/blend.h"

namespace halfshade {
namespace {

// Casting instances in the order in which they are drawn: opaque ones as in the pose, then masked ones by material.
struct Casters {
  std::vector<const Instance*> instances;
  size_t opaque_count = 0;
};

Casters FindCasters(const FlatScene& scene, const Pose& pose, const std::vector<bool>& stands_elsewhere) {
  Casters casters;
  std::vector<const Instance*> masked;
  for (size_t i = 0; i < pose.instances.size(); ++i) {
    const Instance& instance = pose.instances[i];
    if (!instance.casts || (!stands_elsewhere.empty() && stands_elsewhere[i])) continue;
    const MaskCoverage coverage = scene.CoverageOf(scene.meshes[instance.mesh]);
    if (coverage == MaskCoverage::kFull) casters.instances.push_back(&instance);
    if (coverage == MaskCoverage::kTested) masked.push_back(&instance);
  }
  std::stable_sort(masked.begin(), masked.end(), [&](const Instance* a, const Instance* b) {
    return scene.meshes[a->mesh].material < scene.meshes[b->mesh].material;
  });
  casters.opaque_count = casters.instances.size();
  casters.instances.insert(casters.instances.end(), masked.begin(), masked.end());
  return casters;
}

void AddMaskVertices(const FlatScene& scene, const Mesh& mesh, std::vector<MaskVertex>* vertices) {
  const Material& material = scene.materials[mesh.material];
  const auto& texcoords = material.base_color_texture.texcoord == 1 ? scene.texcoords1 : scene.texcoords;
  for (uint32_t i = mesh.first_vertex; i < mesh.first_vertex + mesh.vertex_count; ++i) {
    const glm::vec2 texcoord = texcoords.empty() ? glm::vec2(0) : texcoords[i];
    const float alpha = scene.colors.empty() ? 1 : scene.colors[i].a;
    vertices->emplace_back(texcoord, alpha * material.base_color.a);
  }
}

void AddBlendPlaces(const FlatScene& scene, const Mesh& mesh, const BlendSpace& space, std::vector<glm::vec3>* places) {
  for (uint32_t i = mesh.first_vertex; i < mesh.first_vertex + mesh.vertex_count; ++i) {
    places->push_back(space.Place(scene.positions[i]));
  }
}

// Extends the last run, or starts one.
void AddMasked(uint32_t material, size_t first_index, size_t end_index, std::vector<MaskedOccluders>* masked) {
  if (end_index == first_index) return;
  if (masked->empty() || masked->back().material != material) masked->push_back({material, uint32_t(first_index), 0});
  masked->back().index_count += uint32_t(end_index - first_index);
}

}  // namespace

double LongestAxis(const glm::dmat4& from_mesh) {
  const glm::dmat3 axes(from_mesh);
  return std::max({glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])});
}

LightSpaceOccluders BuildLightSpaceOccluders(const FlatScene& scene, const Pose& pose, const AreaLight& light,
                                             const OccludersElsewhere& elsewhere) {
  const glm::dmat4 light_from_world = LightFromWorld(MakeLightFrame(light));
  LightSpaceOccluders occluders;
  double largest_coordinate = 0;
  double smallest_z = std::numeric_limits<double>::infinity();
  bool crosses_plane = false;
  const auto add_depth = [&](float low) {
    if (low <= 0) {
      crosses_plane = true;
    } else {
      smallest_z = std::min<double>(smallest_z, low);
    }
  };
  const auto add_corner = [&](const glm::vec3& corner) {
    const glm::vec3 p = glm::abs(corner);
    largest_coordinate = std::max<double>(largest_coordinate, std::max({p.x, p.y, p.z}));
  };
  if (!elsewhere.box_ls.IsEmpty()) {
    add_corner(elsewhere.box_ls.min);
    add_corner(elsewhere.box_ls.max);
    add_depth(elsewhere.box_ls.min.z);
  }
  const Casters casters = FindCasters(scene, pose, elsewhere.stands_there);
  const bool has_blend = HasBlendCaster(scene, pose);
  for (size_t c = 0; c < casters.instances.size(); ++c) {
    const Instance& instance = *casters.instances[c];
    const Mesh& mesh = scene.meshes[instance.mesh];
    const glm::dmat4 light_from_mesh = light_from_world * instance.world_from_mesh;
    const uint32_t first_vertex = uint32_t(occluders.positions.size());
    const size_t first_index = occluders.indices.size();
    if (c == casters.opaque_count) occluders.first_masked_vertex = first_vertex;
    for (uint32_t i = 0; i < mesh.vertex_count; ++i) {
      occluders.positions.push_back(PointInLight(light_from_mesh, scene.positions[mesh.first_vertex + i]));
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
        add_corner(occluders.positions[first_vertex + corner[k]]);
        occluders.indices.push_back(first_vertex + corner[k]);
      }
      add_depth(low);
    }
    if (c >= casters.opaque_count) {
      AddMaskVertices(scene, mesh, &occluders.mask_vertices);
      if (has_blend) AddBlendPlaces(scene, mesh, BlendSpace(mesh, instance), &occluders.blend_places);
      AddMasked(mesh.material, first_index, occluders.indices.size(), &occluders.masked);
    } else {
      const auto count = uint32_t(occluders.indices.size() - first_index);
      occluders.runs.push_back(
          {instance.mesh, first_vertex, uint32_t(first_index), count, LongestAxis(instance.world_from_mesh)});
    }
  }
  const double floor = std::ldexp(largest_coordinate, -20);
  double z_near = crosses_plane ? floor : smallest_z * (1 - std::ldexp(1.0, -10));
  if (occluders.indices.empty() && elsewhere.box_ls.IsEmpty()) z_near = 1;
  occluders.hull = OccluderHull(light.width_m / 2, light.height_m / 2, z_near);
  for (size_t i = 0; i < occluders.indices.size(); i += 3) {
    const uint32_t* corner = &occluders.indices[i];
    occluders.hull.AddTriangle(occluders.positions[corner[0]], occluders.positions[corner[1]],
                               occluders.positions[corner[2]]);
  }
  return occluders;
}

}  // namespace halfshade
