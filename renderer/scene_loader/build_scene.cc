#include "renderer/scene_loader/build_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <map>

#include "renderer/scene/deform.h"
#include "renderer/scene/pose.h"
#include "renderer/scene_loader/build_meshes.h"
#include "renderer/scene_loader/build_motion.h"
#include "renderer/scene_loader/tinygltf.h"
#include "renderer/scene_loader/validate_gltf.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// A pose lays out every instance and measures its vertices at each request.
constexpr uint64_t kMaxInstancedTrianglesPerTriangle = 5;

std::string Pointer(const char* array, size_t index) { return std::string("/") + array + "/" + std::to_string(index); }

glm::dmat4 LocalMatrix(const tinygltf::Node& node) {
  if (node.matrix.size() == 16) return glm::make_mat4(node.matrix.data());
  glm::dmat4 local(1);
  if (node.translation.size() == 3) local = glm::translate(local, glm::make_vec3(node.translation.data()));
  if (node.rotation.size() == 4) {
    const glm::dquat rotation(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
    if (glm::length(rotation) > 0) local = local * glm::mat4_cast(glm::normalize(rotation));
  }
  if (node.scale.size() == 3) local = glm::scale(local, glm::make_vec3(node.scale.data()));
  return local;
}

class Builder {
 public:
  Builder(const GltfData& data, const SceneLoadLimits& limits, Gltf* gltf)
      : data_(data), model_(*data.model), limits_(limits), gltf_(*gltf) {}

  absl::StatusOr<FlatScene> Build() {
    texcoords_ = BuildMaterials(data_, limits_, &gltf_, &scene_);
    BuildSkins(data_, &scene_);
    RETURN_IF_ERROR(BuildMeshes());
    RETURN_IF_ERROR(BuildNodes());
    RETURN_IF_ERROR(Deform({}, scene_.morph_weights, &scene_));
    RETURN_IF_ERROR(CheckPlaces());
    BuildCameras();
    BuildScenes();
    RETURN_IF_ERROR(BuildAnimations(data_, limits_, &gltf_, &scene_));
    SuggestLights(gltf_, scene_, &gltf_.warnings);
    scene_.warnings = gltf_.warnings.Take();
    if (scene_.SizeBytes() > limits_.max_scene_bytes) {
      return absl::InvalidArgumentError("/: the scene takes " + std::to_string(scene_.SizeBytes()) +
                                        " bytes; at most " + std::to_string(limits_.max_scene_bytes));
    }
    return std::move(scene_);
  }

 private:
  bool HasTargets(size_t mesh) const {
    const auto& primitives = model_.meshes[mesh].primitives;
    return std::any_of(primitives.begin(), primitives.end(), [](const auto& p) { return !p.targets.empty(); });
  }
  bool IsDeformed(const tinygltf::Node& node) const {
    return node.mesh >= 0 && (node.skin >= 0 || HasTargets(size_t(node.mesh)));
  }

  // Every mesh once for all nodes that do not bend it, and once for each one that does.
  absl::Status BuildMeshes() {
    MeshBuilder builder(data_, limits_, texcoords_, &scene_, &gltf_.warnings);
    std::vector<bool> is_deformed(model_.meshes.size(), false), is_shared(model_.meshes.size(), false);
    for (const tinygltf::Node& node : model_.nodes) {
      if (node.mesh >= 0) (IsDeformed(node) ? is_deformed : is_shared)[size_t(node.mesh)] = true;
    }
    for (size_t m = 0; m < model_.meshes.size(); ++m) {
      MeshRange range{uint32_t(scene_.meshes.size()), 0};
      if (is_shared[m] || !is_deformed[m]) RETURN_IF_ERROR(AddMesh(m, nullptr, &builder, &range));
      shared_.push_back(range);
    }
    for (size_t n = 0; n < model_.nodes.size(); ++n) {
      const tinygltf::Node& node = model_.nodes[n];
      if (!IsDeformed(node)) continue;
      const DeformingNode deforming{uint32_t(n), node.skin >= 0};
      RETURN_IF_ERROR(AddMesh(size_t(node.mesh), &deforming, &builder, &deformed_[n]));
    }
    if (scene_.degenerate_triangles_dropped > 0) {
      gltf_.warnings.Add(
          "/meshes", "triangles without an area are dropped: " + std::to_string(scene_.degenerate_triangles_dropped));
    }
    return absl::OkStatus();
  }

  struct MeshRange {
    uint32_t first = 0, count = 0;
  };
  absl::Status AddMesh(size_t m, const DeformingNode* deforming, MeshBuilder* builder, MeshRange* range) {
    range->first = uint32_t(scene_.meshes.size());
    for (size_t p = 0; p < model_.meshes[m].primitives.size(); ++p) {
      const std::string pointer = Pointer("meshes", m) + "/primitives/" + std::to_string(p);
      RETURN_IF_ERROR(builder->Add(model_.meshes[m].primitives[p], pointer, deforming));
    }
    range->count = uint32_t(scene_.meshes.size()) - range->first;
    return absl::OkStatus();
  }

  // Its own, else the mesh's, else zeros: as many as the mesh has targets.
  absl::Status BuildWeights(const tinygltf::Node& source, Node* node) {
    if (source.mesh < 0) return absl::OkStatus();
    const tinygltf::Mesh& mesh = model_.meshes[size_t(source.mesh)];
    node->first_weight = uint32_t(scene_.morph_weights.size());
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      node->weight_count = std::max(node->weight_count, uint32_t(primitive.targets.size()));
    }
    if ((scene_.morph_weights.size() + node->weight_count) * sizeof(float) > limits_.max_scene_bytes) {
      return absl::InvalidArgumentError(Pointer("nodes", scene_.nodes.size()) +
                                        ": weights of morph targets take over " +
                                        std::to_string(limits_.max_scene_bytes) + " bytes, the limit");
    }
    const std::vector<double>& weights = source.weights.empty() ? mesh.weights : source.weights;
    if (!weights.empty() && weights.size() != node->weight_count) {
      gltf_.warnings.Add(
          Pointer("meshes", size_t(source.mesh)) + "/weights",
          std::to_string(weights.size()) + " weights for " + std::to_string(node->weight_count) + " morph targets");
    }
    for (size_t i = 0; i < node->weight_count; ++i) {
      scene_.morph_weights.push_back(i < weights.size() ? float(weights[i]) : 0.0f);
    }
    return absl::OkStatus();
  }

  absl::Status BuildNodes() {
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
      const tinygltf::Node& source = model_.nodes[i];
      Node node;
      node.name = source.name;
      node.local = LocalMatrix(source);
      if (source.mesh >= 0) {
        const MeshRange range = IsDeformed(source) ? deformed_[i] : shared_[size_t(source.mesh)];
        node.first_mesh = range.first;
        node.mesh_count = range.count;
        node.skin = source.skin;
      }
      node.camera = source.camera;
      RETURN_IF_ERROR(BuildWeights(source, &node));
      if (const auto extensions = gltf_.node_extensions.find(i); extensions != gltf_.node_extensions.end()) {
        RETURN_IF_ERROR(
            BuildPlaces(data_, Place(extensions->second, Pointer("nodes", i) + "/extensions"), &node, &scene_));
      }
      scene_.nodes.push_back(node);
    }
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
      for (const int child : model_.nodes[i].children) scene_.nodes[size_t(child)].parent = int32_t(i);
    }
    return absl::OkStatus();
  }

  absl::Status CheckPlaces() {
    const std::vector<glm::dmat4> world = WorldFromNodes(scene_);
    for (size_t i = 0; i < scene_.nodes.size(); ++i) RETURN_IF_ERROR(CheckPlace(i, world[i]));
    return absl::OkStatus();
  }

  // Matrices multiply along a chain, and meshes along the instances: each may be small and the product not.
  absl::Status CheckPlace(size_t index, const glm::dmat4& world_from_node) {
    const Node& node = scene_.nodes[index];
    for (int i = 0; i < 16; ++i) {
      if (!std::isfinite(glm::value_ptr(world_from_node)[i])) {
        return absl::InvalidArgumentError(Pointer("nodes", index) + ": its world matrix is not finite");
      }
    }
    const uint64_t copies = std::max(1u, node.place_count);
    instances_ += copies * node.mesh_count;
    if (instances_ > kMaxElements) {
      return absl::InvalidArgumentError(Pointer("nodes", index) + ": the scene has over " +
                                        std::to_string(kMaxElements) + " instances of meshes, the limit" +
                                        (node.place_count > 0 ? " (EXT_mesh_gpu_instancing)" : ""));
    }
    for (uint32_t m = node.first_mesh; m < node.first_mesh + node.mesh_count; ++m) {
      instanced_triangles_ += copies * scene_.meshes[m].TriangleCount();
      const uint64_t limit = kMaxInstancedTrianglesPerTriangle * limits_.max_triangles;
      if (instanced_triangles_ > limit) {
        return absl::InvalidArgumentError(Pointer("nodes", index) + ": the instances have over " +
                                          std::to_string(limit) + " triangles, the limit");
      }
      if (node.skin >= 0) continue;  // stands in the world, where Deform has checked it
      for (uint32_t p = 0; p < copies; ++p) {
        const Mesh& mesh = scene_.meshes[m];
        if (BoxInWorld(mesh, glm::translate(WorldFromPlace(scene_, node, p, world_from_node), mesh.origin))) continue;
        return absl::InvalidArgumentError(Pointer("nodes", index) + ": its mesh reaches over 1e18 m away");
      }
    }
    return absl::OkStatus();
  }

  void BuildCameras() {
    for (const tinygltf::Camera& source : model_.cameras) {
      SceneCamera camera;
      camera.name = source.name;
      camera.is_orthographic = source.type == "orthographic";
      if (camera.is_orthographic) {
        camera.ortho_height_m = 2 * std::abs(source.orthographic.ymag);
        camera.near_m = source.orthographic.znear;
        camera.far_m = source.orthographic.zfar;
      } else {
        // The validator warns of the impossible ones; just below 180 degrees keeps them finite.
        camera.fovy_rad = std::min(source.perspective.yfov, 3.1);
        camera.near_m = source.perspective.znear;
        camera.far_m = source.perspective.zfar;
      }
      scene_.cameras.push_back(camera);
    }
  }

  // A file without scenes shows all of its roots.
  void BuildScenes() {
    for (const tinygltf::Scene& source : model_.scenes) {
      scene_.scenes.push_back({source.name, {source.nodes.begin(), source.nodes.end()}});
    }
    if (scene_.scenes.empty()) {
      SceneRoots all;
      for (uint32_t i = 0; i < scene_.nodes.size(); ++i) {
        if (scene_.nodes[i].parent < 0) all.roots.push_back(i);
      }
      scene_.scenes.push_back(all);
    }
    scene_.default_scene = uint32_t(std::max(model_.defaultScene, 0));
  }

  const GltfData& data_;
  const tinygltf::Model& model_;
  const SceneLoadLimits& limits_;
  Gltf& gltf_;
  FlatScene scene_;
  std::vector<TexcoordSources> texcoords_;  // of materials
  std::vector<MeshRange> shared_;           // of each glTF mesh
  std::map<size_t, MeshRange> deformed_;    // of each node that bends its mesh
  uint64_t instances_ = 0, instanced_triangles_ = 0;
};

}  // namespace

absl::StatusOr<FlatScene> BuildFlatScene(const GltfData& data, const SceneLoadLimits& limits, Gltf* gltf) {
  return Builder(data, limits, gltf).Build();
}

}  // namespace halfshade
