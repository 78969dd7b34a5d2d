#include "renderer/light/kept_meshes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string_view>
#include <tuple>

#include "renderer/math/light_frame.h"

namespace halfshade {
namespace {

// Of each mesh the first one with the same triangles.
class Geometries {
 public:
  explicit Geometries(const FlatScene& scene) : scene_(scene) {}

  // Ask once for each.
  uint32_t FirstLike(uint32_t index) {
    const Mesh& mesh = scene_.meshes[index];
    std::vector<uint32_t>& firsts = alike_[{mesh.vertex_count, mesh.index_count, HashOf(mesh)}];
    const auto found = std::find_if(firsts.begin(), firsts.end(),
                                    [&](uint32_t first) { return AreEqual(mesh, scene_.meshes[first]); });
    if (found != firsts.end()) return *found;
    firsts.push_back(index);
    return index;
  }

 private:
  size_t HashOf(const Mesh& mesh) const {
    const auto hash = [](const auto* items, size_t count) {
      return std::hash<std::string_view>()({reinterpret_cast<const char*>(items), count * sizeof(*items)});
    };
    return hash(&scene_.positions[mesh.first_vertex], mesh.vertex_count) ^
           3 * hash(&scene_.indices[mesh.first_index], mesh.index_count);
  }

  bool AreEqual(const Mesh& a, const Mesh& b) const {
    const auto positions = scene_.positions.begin();
    const auto indices = scene_.indices.begin();
    return std::equal(positions + a.first_vertex, positions + a.first_vertex + a.vertex_count,
                      positions + b.first_vertex) &&
           std::equal(indices + a.first_index, indices + a.first_index + a.index_count, indices + b.first_index);
  }

  const FlatScene& scene_;
  // By the numbers of vertices and indices, and the hash of them all: of many meshes of one size few are compared.
  std::map<std::tuple<uint32_t, uint32_t, size_t>, std::vector<uint32_t>> alike_;
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

Box3f BoxInLight(const FlatScene& scene, const Mesh& mesh, const glm::dmat4& light_from_mesh) {
  Box3f box;
  for (uint32_t i = mesh.first_vertex; i < mesh.first_vertex + mesh.vertex_count; ++i) {
    box.Add(PointInLight(light_from_mesh, scene.positions[i]));
  }
  return box;
}

}  // namespace

std::vector<uint32_t> FindKeptMeshes(const FlatScene& scene) {
  std::vector<uint64_t> places(scene.meshes.size(), 0);
  for (const Node& node : scene.nodes) {
    for (uint32_t i = 0; i < node.mesh_count; ++i) places[node.first_mesh + i] += std::max(node.place_count, 1u);
  }
  Geometries geometries(scene);
  std::vector<uint32_t> kept(scene.meshes.size(), kNotKept);
  for (uint32_t i = 0; i < kept.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    if (mesh.TriangleCount() < kLeastKeptTriangles || scene.CoverageOf(mesh) != MaskCoverage::kFull) continue;
    kept[i] = geometries.FirstLike(i);
    if (kept[i] != i) places[kept[i]] += places[i];
  }
  for (uint32_t& first : kept) {
    if (first != kNotKept && !IsWorthKeeping(scene.meshes[first].TriangleCount(), places[first])) first = kNotKept;
  }
  return kept;
}

KeptPlaces FindKeptPlaces(const FlatScene& scene, const Pose& pose, const std::vector<uint32_t>& kept_meshes,
                          const AreaLight& light) {
  KeptPlaces found;
  found.elsewhere.stands_there.resize(pose.instances.size(), false);
  const glm::dmat4 light_from_world = LightFromWorld(MakeLightFrame(light));
  for (size_t i = 0; i < pose.instances.size(); ++i) {
    const Instance& instance = pose.instances[i];
    const uint32_t mesh = kept_meshes[instance.mesh];
    if (!instance.casts || mesh == kNotKept || !KeepsShape(instance.world_from_mesh)) continue;
    found.elsewhere.stands_there[i] = true;
    KeptPlace place;
    place.mesh = mesh;
    place.light_from_mesh = light_from_world * instance.world_from_mesh;
    place.box_ls = BoxInLight(scene, scene.meshes[mesh], place.light_from_mesh);
    place.scale = LongestAxis(instance.world_from_mesh);
    if (place.box_ls.max.z <= 0) continue;
    found.elsewhere.box_ls.Add(place.box_ls.min);
    found.elsewhere.box_ls.Add(place.box_ls.max);
    found.places.push_back(place);
  }
  return found;
}

}  // namespace halfshade
