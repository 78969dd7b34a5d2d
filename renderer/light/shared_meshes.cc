#include "renderer/light/shared_meshes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "renderer/light/occluders.h"
#include "renderer/math/light_frame.h"

namespace halfshade {
namespace {

constexpr uint32_t kUnknown = ~0u;

// Of each mesh the first one with the same triangles.
class Geometries {
 public:
  explicit Geometries(const FlatScene& scene) : scene_(scene), first_(scene.meshes.size(), kUnknown) {}

  uint32_t FirstLike(uint32_t index) {
    if (first_[index] != kUnknown) return first_[index];
    const Mesh& mesh = scene_.meshes[index];
    std::vector<uint32_t>& firsts = by_size_[{mesh.vertex_count, mesh.index_count}];
    const auto found = std::find_if(firsts.begin(), firsts.end(),
                                    [&](uint32_t first) { return AreEqual(mesh, scene_.meshes[first]); });
    if (found != firsts.end()) return first_[index] = *found;
    firsts.push_back(index);
    return first_[index] = index;
  }

 private:
  bool AreEqual(const Mesh& a, const Mesh& b) const {
    const auto positions = scene_.positions.begin();
    const auto indices = scene_.indices.begin();
    return std::equal(positions + a.first_vertex, positions + a.first_vertex + a.vertex_count,
                      positions + b.first_vertex) &&
           std::equal(indices + a.first_index, indices + a.first_index + a.index_count, indices + b.first_index);
  }

  const FlatScene& scene_;
  std::vector<uint32_t> first_;
  std::map<std::pair<uint32_t, uint32_t>, std::vector<uint32_t>> by_size_;
};

// Whether no direction is squeezed more than sixteenfold beside another, or somewhat more where only one is. The
// product is 3 for what keeps all angles and at least sqrt(2 + s^2) sqrt(2 + 1 / s^2) for a squeeze s.
bool KeepsShape(const glm::dmat4& from_mesh) {
  constexpr double kMost = 24;
  const auto norm = [](const glm::dmat3& m) {
    return std::sqrt(glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]));
  };
  const glm::dmat3 axes(from_mesh);
  // False where there is no inverse.
  return norm(axes) * norm(glm::inverse(axes)) <= kMost;
}

SharedMesh MakeSharedMesh(const FlatScene& scene, uint32_t index) {
  const Mesh& mesh = scene.meshes[index];
  SharedMesh shared;
  shared.mesh = index;
  const auto position = scene.positions.begin() + mesh.first_vertex;
  const auto first = scene.indices.begin() + mesh.first_index;
  shared.positions.assign(position, position + mesh.vertex_count);
  shared.indices.assign(first, first + mesh.index_count);
  return shared;
}

Box3f BoxInLight(const SharedMesh& mesh, const std::vector<bool>& is_used, const glm::dmat4& light_from_mesh) {
  Box3f box;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    if (is_used[i]) box.Add(PointInLight(light_from_mesh, mesh.positions[i]));
  }
  return box;
}

float LargestCoordinate(const Box3f& box) {
  const glm::vec3 most = glm::max(glm::abs(box.min), glm::abs(box.max));
  return std::max({most.x, most.y, most.z});
}

bool IsInFront(const Box3f& box) { return box.min.z > std::ldexp(LargestCoordinate(box), -20); }

}  // namespace

SharedMeshes FindSharedMeshes(const FlatScene& scene, const Pose& pose, const AreaLight& light) {
  SharedMeshes found;
  found.rest = pose;
  Geometries geometries(scene);
  std::map<uint32_t, std::vector<uint32_t>> instances;  // by mesh, in their order
  for (uint32_t i = 0; i < pose.instances.size(); ++i) {
    const Instance& instance = pose.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (!instance.casts || mesh.TriangleCount() < kLeastSharedTriangles) continue;
    if (!KeepsShape(instance.world_from_mesh) || scene.CoverageOf(mesh) != MaskCoverage::kFull) continue;
    instances[geometries.FirstLike(instance.mesh)].push_back(i);
  }
  const glm::dmat4 light_from_world = LightFromWorld(MakeLightFrame(light));
  for (const auto& [mesh, users] : instances) {
    const uint32_t triangles = scene.meshes[mesh].TriangleCount();
    if (!IsWorthSharing(triangles, users.size())) continue;
    SharedMesh shared = MakeSharedMesh(scene, mesh);
    std::vector<bool> is_used(shared.positions.size(), false);
    for (const uint32_t i : shared.indices) is_used[i] = true;
    std::vector<uint32_t> gone;  // from the rest
    for (const uint32_t i : users) {
      SharedMesh::Place place;
      place.light_from_mesh = light_from_world * pose.instances[i].world_from_mesh;
      place.box_ls = BoxInLight(shared, is_used, place.light_from_mesh);
      place.scale = LongestAxis(pose.instances[i].world_from_mesh);
      const bool is_behind = place.box_ls.max.z <= 0;
      if (!is_behind && !IsInFront(place.box_ls)) continue;
      gone.push_back(i);
      if (!is_behind) shared.places.push_back(place);
    }
    if (!IsWorthSharing(triangles, shared.places.size())) continue;
    for (const uint32_t i : gone) found.rest.instances[i].casts = false;
    for (const SharedMesh::Place& place : shared.places) {
      found.largest_coordinate_m = std::max(found.largest_coordinate_m, LargestCoordinate(place.box_ls));
    }
    found.meshes.push_back(std::move(shared));
  }
  return found;
}

}  // namespace halfshade
