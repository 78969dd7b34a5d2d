#include "renderer/scene_loader/build_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "renderer/scene_loader/build_meshes.h"
#include "renderer/scene_loader/decode_image.h"
#include "renderer/scene_loader/tinygltf.h"
#include "renderer/scene_loader/validate_gltf.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// A pose lays out every instance and measures its vertices at each request.
constexpr uint64_t kMaxInstancedTrianglesPerTriangle = 5;

std::string Pointer(const char* array, size_t index) { return std::string("/") + array + "/" + std::to_string(index); }

Wrap ToWrap(int mode) {
  return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? Wrap::kClampToEdge
         : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::kMirroredRepeat
                                                         : Wrap::kRepeat;
}

// glTF leaves an absent filter (-1) to us: linear, with mips.
bool MinifiesToNearest(int filter) {
  return filter == TINYGLTF_TEXTURE_FILTER_NEAREST || filter == TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST ||
         filter == TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_LINEAR;
}

MipFilter ToMipFilter(int filter) {
  switch (filter) {
    case TINYGLTF_TEXTURE_FILTER_NEAREST:
    case TINYGLTF_TEXTURE_FILTER_LINEAR:
      return MipFilter::kNone;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST:
    case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_NEAREST:
      return MipFilter::kNearest;
    default:
      return MipFilter::kLinear;
  }
}

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
    BuildImages();
    BuildTextures();
    for (size_t i = 0; i < model_.materials.size(); ++i) BuildMaterial(model_.materials[i], Pointer("materials", i));
    scene_.materials.emplace_back();  // glTF's default
    RETURN_IF_ERROR(BuildMeshes());
    RETURN_IF_ERROR(BuildNodes());
    BuildCameras();
    BuildScenes();
    scene_.warnings = gltf_.warnings.Take();
    if (scene_.SizeBytes() > limits_.max_scene_bytes) {
      return absl::InvalidArgumentError("/: the scene takes " + std::to_string(scene_.SizeBytes()) +
                                        " bytes; at most " + std::to_string(limits_.max_scene_bytes));
    }
    return std::move(scene_);
  }

 private:
  // Images that we cannot read are left out: their textures' materials keep their factor alone.
  void BuildImages() {
    for (size_t i = 0; i < gltf_.images.size(); ++i) {
      EncodedImage image{Pointer("images", i), std::string(gltf_.images[i])};
      const ImageHeader header = ReadImageHeader(image.bytes);
      image.width = header.width;
      image.height = header.height;
      image_of_gltf_.push_back(-1);
      if (header.format == ImageFormat::kUnknown) {
        gltf_.warnings.Add(image.name, "neither a PNG nor a JPEG; its textures are left out");
      } else if (!header.IsWithin(limits_.max_texture_pixels)) {
        gltf_.warnings.Add(image.name, std::to_string(header.width) + " x " + std::to_string(header.height) +
                                           " pixels are over the limit; its textures are left out");
      } else {
        image_of_gltf_.back() = int32_t(scene_.images.size());
        scene_.images.push_back(std::move(image));
      }
    }
  }

  void BuildTextures() {
    for (const tinygltf::Texture& source : model_.textures) {
      const int32_t image = source.source < 0 ? -1 : image_of_gltf_[size_t(source.source)];
      texture_of_gltf_.push_back(-1);
      if (image < 0) continue;
      texture_of_gltf_.back() = int32_t(scene_.textures.size());
      Texture texture;
      texture.image = uint32_t(image);
      if (source.sampler >= 0) {
        const tinygltf::Sampler& sampler = model_.samplers[size_t(source.sampler)];
        texture.wrap_s = ToWrap(sampler.wrapS);
        texture.wrap_t = ToWrap(sampler.wrapT);
        texture.magnifies_to_nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
        texture.minifies_to_nearest = MinifiesToNearest(sampler.minFilter);
        texture.mip_filter = ToMipFilter(sampler.minFilter);
      }
      scene_.textures.push_back(texture);
    }
  }

  // Any of tinygltf's kinds of texture info.
  template <typename Info>
  MaterialTexture BuildMaterialTexture(const Info& source, const std::string& pointer) {
    MaterialTexture result;
    if (source.index < 0) return result;
    result.texture = texture_of_gltf_[size_t(source.index)];
    result.texcoord = source.texCoord == 1 ? 1 : 0;
    if (result.texture < 0) gltf_.warnings.Add(pointer, "has no image that can be read; left out");
    return result;
  }

  void BuildMaterial(const tinygltf::Material& source, const std::string& pointer) {
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    Material material;
    material.name = source.name;
    for (int i = 0; i < 4; ++i) material.base_color[i] = float(pbr.baseColorFactor[size_t(i)]);
    material.base_color_texture =
        BuildMaterialTexture(pbr.baseColorTexture, pointer + "/pbrMetallicRoughness/baseColorTexture");
    material.metallic = float(pbr.metallicFactor);
    material.roughness = float(pbr.roughnessFactor);
    material.metallic_roughness_texture =
        BuildMaterialTexture(pbr.metallicRoughnessTexture, pointer + "/pbrMetallicRoughness/metallicRoughnessTexture");
    material.normal_texture = BuildMaterialTexture(source.normalTexture, pointer + "/normalTexture");
    material.normal_scale = float(source.normalTexture.scale);
    material.occlusion_texture = BuildMaterialTexture(source.occlusionTexture, pointer + "/occlusionTexture");
    material.occlusion_strength = float(source.occlusionTexture.strength);
    for (int i = 0; i < 3; ++i) material.emissive[i] = float(source.emissiveFactor[size_t(i)]);
    material.emissive_texture = BuildMaterialTexture(source.emissiveTexture, pointer + "/emissiveTexture");
    material.alpha_mode = source.alphaMode == "MASK"    ? AlphaMode::kMask
                          : source.alphaMode == "BLEND" ? AlphaMode::kBlend
                                                        : AlphaMode::kOpaque;
    material.alpha_cutoff = float(source.alphaCutoff);
    material.is_double_sided = source.doubleSided;
    scene_.materials.push_back(material);
  }

  absl::Status BuildMeshes() {
    MeshBuilder builder(data_, limits_, &scene_, &gltf_.warnings);
    for (size_t m = 0; m < model_.meshes.size(); ++m) {
      first_mesh_.push_back(uint32_t(scene_.meshes.size()));
      for (size_t p = 0; p < model_.meshes[m].primitives.size(); ++p) {
        const std::string pointer = Pointer("meshes", m) + "/primitives/" + std::to_string(p);
        RETURN_IF_ERROR(builder.Add(model_.meshes[m].primitives[p], pointer));
      }
    }
    first_mesh_.push_back(uint32_t(scene_.meshes.size()));
    if (scene_.degenerate_triangles_dropped > 0) {
      gltf_.warnings.Add(
          "/meshes", "triangles without an area are dropped: " + std::to_string(scene_.degenerate_triangles_dropped));
    }
    return absl::OkStatus();
  }

  absl::Status BuildNodes() {
    for (const tinygltf::Node& source : model_.nodes) {
      Node node;
      node.name = source.name;
      node.local = LocalMatrix(source);
      if (source.mesh >= 0) {
        node.first_mesh = first_mesh_[size_t(source.mesh)];
        node.mesh_count = first_mesh_[size_t(source.mesh) + 1] - node.first_mesh;
      }
      node.camera = source.camera;
      scene_.nodes.push_back(node);
    }
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
      for (const int child : model_.nodes[i].children) scene_.nodes[size_t(child)].parent = int32_t(i);
    }
    std::vector<std::pair<size_t, glm::dmat4>> stack;  // of our own: the graph may be as deep as it has nodes
    for (size_t i = 0; i < scene_.nodes.size(); ++i) {
      if (scene_.nodes[i].parent < 0) stack.emplace_back(i, glm::dmat4(1));
    }
    while (!stack.empty()) {
      const auto [node, world_from_parent] = stack.back();
      stack.pop_back();
      const glm::dmat4 world_from_node = world_from_parent * scene_.nodes[node].local;
      RETURN_IF_ERROR(CheckPlace(node, world_from_node));
      for (const int child : model_.nodes[node].children) stack.emplace_back(size_t(child), world_from_node);
    }
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
    instances_ += node.mesh_count;
    if (instances_ > kMaxElements) {
      return absl::InvalidArgumentError(Pointer("nodes", index) + ": the scene has over " +
                                        std::to_string(kMaxElements) + " instances of meshes, the limit");
    }
    for (uint32_t m = node.first_mesh; m < node.first_mesh + node.mesh_count; ++m) {
      const Mesh& mesh = scene_.meshes[m];
      instanced_triangles_ += mesh.TriangleCount();
      const uint64_t limit = kMaxInstancedTrianglesPerTriangle * limits_.max_triangles;
      if (instanced_triangles_ > limit) {
        return absl::InvalidArgumentError(Pointer("nodes", index) + ": the instances have over " +
                                          std::to_string(limit) + " triangles, the limit");
      }
      for (int corner = 0; corner < 8; ++corner) {
        glm::dvec3 position = mesh.origin;
        for (int i = 0; i < 3; ++i) position[i] += corner >> i & 1 ? mesh.bounds.max[i] : mesh.bounds.min[i];
        const glm::dvec4 world = world_from_node * glm::dvec4(position, 1);
        for (int i = 0; i < 3; ++i) {
          if (std::abs(world[i]) <= kMaxCoordinateM) continue;
          return absl::InvalidArgumentError(Pointer("nodes", index) + ": its mesh reaches over 1e18 m away");
        }
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
  std::vector<int32_t> image_of_gltf_, texture_of_gltf_;  // -1: left out
  std::vector<uint32_t> first_mesh_;                      // of each glTF mesh, and one past the last
  uint64_t instances_ = 0, instanced_triangles_ = 0;
};

}  // namespace

absl::StatusOr<FlatScene> BuildFlatScene(const GltfData& data, const SceneLoadLimits& limits, Gltf* gltf) {
  return Builder(data, limits, gltf).Build();
}

}  // namespace halfshade
