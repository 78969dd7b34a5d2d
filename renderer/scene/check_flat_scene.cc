#include "renderer/scene/check_flat_scene.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <string>
#include <utility>
#include <vector>

#include "renderer/scene/pose.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// Of plain values that are floats throughout. In integers, which the compiler makes vectors of.
template <typename T>
bool AreFinite(const T* values, size_t count) {
  static_assert(sizeof(T) % sizeof(float) == 0);
  constexpr uint32_t kExponent = 0x7f800000;
  const auto* numbers = reinterpret_cast<const float*>(values);
  uint32_t found = 0;
  for (size_t i = 0; i < count * (sizeof(T) / sizeof(float)); ++i) {
    found |= uint32_t((std::bit_cast<uint32_t>(numbers[i]) & kExponent) == kExponent);
  }
  return found == 0;
}
template <typename T>
bool AreFinite(const std::vector<T>& values) {
  return AreFinite(values.data(), values.size());
}
bool IsFinite(const double* numbers, int count) {
  return std::all_of(numbers, numbers + count, [](double number) { return std::isfinite(number); });
}
bool IsFinite(const glm::dvec3& vector) { return IsFinite(glm::value_ptr(vector), 3); }
// A box that nothing was added to is empty.
bool IsSound(const Box3f& box) { return box.IsEmpty() || AreFinite(&box, 1); }

bool IsRun(uint64_t first, uint64_t count, uint64_t size) { return first + count <= size; }
bool IsIndexOrNone(int64_t index, size_t size) { return index >= -1 && index < int64_t(size); }

class Checker {
 public:
  explicit Checker(const FlatScene& scene) : s_(scene), deformed_of_(scene.meshes.size(), nullptr) {}

  absl::Status Check() {
    RETURN_IF_ERROR(CheckNumbers());
    RETURN_IF_ERROR(Each("materials", s_.materials, [this](const Material& it) { return IsValid(it); }));
    RETURN_IF_ERROR(Each("textures", s_.textures, [this](const Texture& it) { return IsValid(it); }));
    RETURN_IF_ERROR(Each("images", s_.images, [](const EncodedImage& it) { return it.width > 0 && it.height > 0; }));
    RETURN_IF_ERROR(Each("cameras", s_.cameras, [](const SceneCamera& it) {
      return IsFinite(glm::value_ptr(glm::dvec4(it.fovy_rad, it.ortho_height_m, it.near_m, it.far_m)), 4);
    }));
    RETURN_IF_ERROR(Each("skins", s_.skins, [this](const Skin& it) {
      return it.joint_count > 0 && IsRun(it.first_joint, it.joint_count, s_.skin_joints.size());
    }));
    RETURN_IF_ERROR(Each("skin_joints", s_.skin_joints, [this](uint32_t joint) { return joint < s_.nodes.size(); }));
    RETURN_IF_ERROR(Each("nodes", s_.nodes, [this](const Node& it) { return IsValid(it); }));
    RETURN_IF_ERROR(CheckForest());
    RETURN_IF_ERROR(Each("scenes", s_.scenes, [this](const SceneRoots& it) {
      std::vector<uint32_t> roots = it.roots;
      std::sort(roots.begin(), roots.end());
      return std::adjacent_find(roots.begin(), roots.end()) == roots.end() &&
             std::all_of(roots.begin(), roots.end(),
                         [this](uint32_t root) { return root < s_.nodes.size() && s_.nodes[root].parent < 0; });
    }));
    if (s_.default_scene >= s_.scenes.size()) return Broken("default_scene", s_.default_scene);
    RETURN_IF_ERROR(Each("deformed", s_.deformed, [this](const Deformed& it) { return IsValid(it); }));
    RETURN_IF_ERROR(Each("meshes", s_.meshes, [this](const Mesh& it) { return IsValid(it); }));
    RETURN_IF_ERROR(CheckMotion());
    return CheckReach();
  }

 private:
  static absl::Status Broken(const char* array, size_t index) {
    return absl::DataLossError("flat scene: " + std::string(array) + "[" + std::to_string(index) + "] is not valid");
  }
  template <typename T, typename Check>
  static absl::Status Each(const char* array, const std::vector<T>& values, const Check& is_valid) {
    for (size_t i = 0; i < values.size(); ++i) {
      if (!is_valid(values[i])) return Broken(array, i);
    }
    return absl::OkStatus();
  }

  absl::Status CheckNumbers() const {
    const size_t vertices = s_.positions.size();
    const auto is_parallel = [&](size_t size) { return size == 0 || size == vertices; };
    if (s_.normals.size() != vertices || s_.texcoords.size() != vertices || !is_parallel(s_.texcoords1.size()) ||
        !is_parallel(s_.tangents.size()) || !is_parallel(s_.colors.size())) {
      return absl::DataLossError("flat scene: arrays of vertices differ in length");
    }
    if (s_.joint_from_mesh.size() != s_.skin_joints.size()) return Broken("joint_from_mesh", s_.skin_joints.size());
    const std::pair<const char*, bool> arrays[] = {{"positions", AreFinite(s_.positions)},
                                                   {"normals", AreFinite(s_.normals)},
                                                   {"texcoords", AreFinite(s_.texcoords)},
                                                   {"texcoords1", AreFinite(s_.texcoords1)},
                                                   {"tangents", AreFinite(s_.tangents)},
                                                   {"colors", AreFinite(s_.colors)},
                                                   {"places", AreFinite(s_.places)},
                                                   {"morph_weights", AreFinite(s_.morph_weights)},
                                                   {"joint_from_mesh", AreFinite(s_.joint_from_mesh)},
                                                   {"bind_vertices", AreFinite(s_.bind_vertices)},
                                                   {"morph_deltas", AreFinite(s_.morph_deltas)},
                                                   {"animation_times", AreFinite(s_.animation_times)},
                                                   {"animation_values", AreFinite(s_.animation_values)}};
    for (const auto& [name, is_finite] : arrays) {
      if (!is_finite) return absl::DataLossError(std::string("flat scene: ") + name + " are not finite");
    }
    return absl::OkStatus();
  }

  bool IsValid(const Material& it) const {
    for (const MaterialTexture* texture : {&it.base_color_texture, &it.metallic_roughness_texture, &it.normal_texture,
                                           &it.occlusion_texture, &it.emissive_texture}) {
      if (!IsIndexOrNone(texture->texture, s_.textures.size()) || texture->texcoord > 1) return false;
    }
    const float factors[] = {it.metallic, it.roughness, it.normal_scale, it.occlusion_strength, it.alpha_cutoff};
    return it.alpha_mode <= AlphaMode::kBlend && AreFinite(factors, 5) && AreFinite(&it.base_color, 1) &&
           AreFinite(&it.emissive, 1);
  }
  bool IsValid(const Texture& it) const {
    return it.image < s_.images.size() && it.wrap_s <= Wrap::kMirroredRepeat && it.wrap_t <= Wrap::kMirroredRepeat &&
           it.mip_filter <= MipFilter::kLinear;
  }
  bool IsValid(const Node& it) const {
    return IsIndexOrNone(it.parent, s_.nodes.size()) && IsFinite(glm::value_ptr(it.local), 16) &&
           IsRun(it.first_mesh, it.mesh_count, s_.meshes.size()) && IsIndexOrNone(it.camera, s_.cameras.size()) &&
           IsIndexOrNone(it.skin, s_.skins.size()) && IsRun(it.first_place, it.place_count, s_.places.size()) &&
           (it.skin < 0 || it.place_count == 0) && IsRun(it.first_weight, it.weight_count, s_.morph_weights.size());
  }

  // No node is its own ancestor.
  absl::Status CheckForest() const {
    enum : uint8_t { kNew, kOnPath, kDone };
    std::vector<uint8_t> states(s_.nodes.size(), kNew);
    std::vector<size_t> path;
    for (size_t i = 0; i < s_.nodes.size(); ++i) {
      for (int64_t at = int64_t(i); at >= 0 && states[size_t(at)] != kDone; at = s_.nodes[size_t(at)].parent) {
        if (states[size_t(at)] == kOnPath) return Broken("nodes", size_t(at));
        states[size_t(at)] = kOnPath;
        path.push_back(size_t(at));
      }
      for (; !path.empty(); path.pop_back()) states[path.back()] = kDone;
    }
    return absl::OkStatus();
  }

  bool IsValid(const Deformed& it) {
    if (it.node >= s_.nodes.size() || it.mesh >= s_.meshes.size() || deformed_of_[it.mesh] != nullptr) return false;
    deformed_of_[it.mesh] = &it;
    const Node& node = s_.nodes[it.node];
    const Mesh& mesh = s_.meshes[it.mesh];
    const uint64_t vertices = mesh.vertex_count;
    if (it.mesh < node.first_mesh || it.mesh - node.first_mesh >= node.mesh_count ||
        it.target_count > node.weight_count || it.bind_index_count % 3 != 0 ||
        !IsRun(it.first_bind, vertices, s_.bind_vertices.size()) ||
        !IsRun(it.first_bind_index, it.bind_index_count, s_.bind_indices.size()) ||
        !IsRun(it.first_influence, vertices * it.influence_count, s_.influences.size()) ||
        !IsRun(it.first_delta, vertices * it.target_count, s_.morph_deltas.size())) {
      return false;
    }
    for (uint32_t i = 0; i < it.bind_index_count; ++i) {
      if (s_.bind_indices[it.first_bind_index + i] >= vertices) return false;
    }
    if (it.influence_count > 0 && node.skin < 0) return false;
    for (uint64_t i = 0; i < vertices * it.influence_count; ++i) {
      const Influence& influence = s_.influences[it.first_influence + i];
      if (influence.joint >= s_.skins[size_t(node.skin)].joint_count || !std::isfinite(influence.weight)) return false;
    }
    return true;
  }

  // Meshes come in order, so that none has another one's vertices, indices or clusters.
  bool IsValid(const Mesh& it) {
    const Deformed* deformed = deformed_of_[size_t(&it - s_.meshes.data())];
    const uint32_t room = deformed == nullptr ? it.index_count : deformed->bind_index_count;  // of its indices
    const auto clusters_of = [](uint32_t indices) {
      return (indices / 3 + Cluster::kMaxTriangles - 1) / Cluster::kMaxTriangles;
    };
    if (it.first_vertex < next_vertex_ || it.first_index < next_index_ || it.first_cluster < next_cluster_ ||
        it.index_count > room || it.index_count % 3 != 0 || it.cluster_count != clusters_of(it.index_count) ||
        !IsRun(it.first_vertex, it.vertex_count, s_.positions.size()) ||
        !IsRun(it.first_index, room, s_.indices.size()) ||
        !IsRun(it.first_cluster, clusters_of(room), s_.clusters.size()) || it.material >= s_.materials.size() ||
        !IsFinite(it.origin) || !IsSound(it.bounds) || it.bounds.IsEmpty() != (it.vertex_count == 0)) {
      return false;
    }
    next_vertex_ = uint64_t(it.first_vertex) + it.vertex_count;
    next_index_ = uint64_t(it.first_index) + room;
    next_cluster_ = uint64_t(it.first_cluster) + clusters_of(room);
    const uint32_t* indices = s_.indices.data() + it.first_index;
    if (std::any_of(indices, indices + it.index_count, [&](uint32_t index) { return index >= it.vertex_count; })) {
      return false;
    }
    for (uint32_t c = 0; c < it.cluster_count; ++c) {
      const Cluster& cluster = s_.clusters[it.first_cluster + c];
      const uint32_t first = c * Cluster::kMaxTriangles;
      const uint32_t count = std::min(Cluster::kMaxTriangles, it.TriangleCount() - first);
      if (cluster.first_triangle != first || cluster.triangle_count != count || !AreFinite(&cluster.bounds, 1)) {
        return false;
      }
    }
    return true;
  }

  absl::Status CheckMotion() const {
    RETURN_IF_ERROR(Each("rests", s_.rests, [this](const Rest& it) {
      const size_t index = size_t(&it - s_.rests.data());
      return it.node < s_.nodes.size() && (index == 0 || s_.rests[index - 1].node < it.node) &&
             IsFinite(it.translation) && IsFinite(glm::value_ptr(it.rotation), 4) && IsFinite(it.scale);
    }));
    RETURN_IF_ERROR(Each("animations", s_.animations, [this](const Animation& it) {
      return IsRun(it.first_channel, it.channel_count, s_.channels.size()) && std::isfinite(it.duration_s);
    }));
    return Each("channels", s_.channels, [this](const AnimationChannel& it) { return IsValid(it); });
  }
  bool IsValid(const AnimationChannel& it) const {
    if (it.node >= s_.nodes.size() || it.path > AnimatedPath::kWeights || it.interpolation > Interpolation::kCubic) {
      return false;
    }
    const uint32_t width = it.path == AnimatedPath::kWeights    ? s_.nodes[it.node].weight_count
                           : it.path == AnimatedPath::kRotation ? 4
                                                                : 3;
    const uint64_t rows = uint64_t(it.key_count) * (it.interpolation == Interpolation::kCubic ? 3 : 1);
    const auto rest = std::lower_bound(s_.rests.begin(), s_.rests.end(), it.node,
                                       [](const Rest& a, uint32_t node) { return a.node < node; });
    if (it.width != width || it.key_count == 0 || !IsRun(it.first_time, it.key_count, s_.animation_times.size()) ||
        (width > 0 && rows > s_.animation_values.size() / width) ||
        !IsRun(it.first_value, rows * width, s_.animation_values.size()) || rest == s_.rests.end() ||
        rest->node != it.node) {
      return false;
    }
    const float* times = s_.animation_times.data() + it.first_time;
    return std::is_sorted(times, times + it.key_count);
  }

  absl::Status CheckReach() const {
    const std::vector<glm::dmat4> world = WorldFromNodes(s_);
    for (size_t i = 0; i < s_.nodes.size(); ++i) {
      const Node& node = s_.nodes[i];
      if (!IsFinite(glm::value_ptr(world[i]), 16)) return Broken("nodes", i);
      for (uint32_t p = 0; p < std::max(1u, node.place_count); ++p) {
        const glm::dmat4 world_from_mesh = node.skin >= 0 ? glm::dmat4(1) : WorldFromPlace(s_, node, p, world[i]);
        for (uint32_t m = node.first_mesh; m < node.first_mesh + node.mesh_count; ++m) {
          const Mesh& mesh = s_.meshes[m];
          if (mesh.vertex_count > 0 && !BoxInWorld(mesh, glm::translate(world_from_mesh, mesh.origin))) {
            return Broken("nodes", i);
          }
        }
      }
    }
    return absl::OkStatus();
  }
  const FlatScene& s_;
  std::vector<const Deformed*> deformed_of_;  // by mesh: what bends it, or null
  uint64_t next_vertex_ = 0, next_index_ = 0, next_cluster_ = 0;
};

}  // namespace

absl::Status CheckFlatScene(const FlatScene& scene) { return Checker(scene).Check(); }

}  // namespace halfshade
