#include "renderer/scene_loader/build_scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "renderer/scene_loader/image_header.h"
#include "renderer/scene_loader/tinygltf.h"
#include "renderer/scene_loader/validate_gltf.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

std::string Pointer(const char* array, size_t index) { return std::string("/") + array + "/" + std::to_string(index); }

// Elements of one accessor, as the validator has found them to lie inside their buffer.
class Elements {
 public:
  Elements(const tinygltf::Model& model, int accessor)
      : accessor_(model.accessors[size_t(accessor)]), component_bytes_(ComponentBytes(accessor_.componentType)) {
    const tinygltf::BufferView& view = model.bufferViews[size_t(accessor_.bufferView)];
    const int components = tinygltf::GetNumComponentsInType(uint32_t(accessor_.type));
    stride_ = view.byteStride != 0 ? view.byteStride : size_t(component_bytes_ * components);
    data_ = model.buffers[size_t(view.buffer)].data.data() + view.byteOffset + accessor_.byteOffset;
  }

  size_t count() const { return accessor_.count; }

  uint32_t Index(size_t element) const {
    uint32_t value = 0;
    std::memcpy(&value, data_ + element * stride_, size_t(component_bytes_));
    return value;
  }

  // Floats as they are, unsigned integers normalized.
  float Float(size_t element, int component) const {
    const unsigned char* at = data_ + element * stride_ + size_t(component * component_bytes_);
    if (accessor_.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) {
      float value = 0;
      std::memcpy(&value, at, sizeof(value));
      return value;
    }
    if (component_bytes_ == 1) return float(*at) / 255.0f;
    uint16_t value = 0;
    std::memcpy(&value, at, sizeof(value));
    return float(value) / 65535.0f;
  }

  template <typename Vec>
  Vec Vector(size_t element) const {
    Vec value;
    for (int i = 0; i < Vec::length(); ++i) value[i] = Float(element, i);
    return value;
  }

 private:
  const tinygltf::Accessor& accessor_;
  int component_bytes_;
  size_t stride_ = 0;
  const unsigned char* data_ = nullptr;
};

class Builder {
 public:
  Builder(const tinygltf::Model& model, const SceneLoadLimits& limits) : model_(model), limits_(limits) {}

  absl::StatusOr<FlatScene> Build(std::vector<std::string> images, std::vector<std::string> warnings) {
    scene_.warnings = std::move(warnings);
    BuildTextures(std::move(images));
    for (const tinygltf::Material& material : model_.materials) BuildMaterial(material);
    scene_.materials.emplace_back();  // glTF's default
    RETURN_IF_ERROR(BuildMeshes());
    RETURN_IF_ERROR(BuildNodes());
    BuildCameras();
    BuildScenes();
    if (scene_.degenerate_triangles_dropped > 0) {
      scene_.warnings.push_back("/meshes: " + std::to_string(scene_.degenerate_triangles_dropped) +
                                " triangles without an area are dropped");
    }
    if (scene_.SizeBytes() > limits_.max_scene_bytes) {
      return absl::InvalidArgumentError("/: the scene takes " + std::to_string(scene_.SizeBytes()) +
                                        " bytes; at most " + std::to_string(limits_.max_scene_bytes));
    }
    return std::move(scene_);
  }

 private:
  static Wrap ToWrap(int mode) {
    return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? Wrap::kClampToEdge
           : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::kMirroredRepeat
                                                           : Wrap::kRepeat;
  }

  // Textures keep their numbers; those whose image we cannot read are known by an empty image.
  void BuildTextures(std::vector<std::string> images) {
    for (size_t i = 0; i < images.size(); ++i) {
      const ImageHeader header = ReadImageHeader(images[i]);
      EncodedImage image;
      image.name = Pointer("images", i);
      image.width = header.width;
      image.height = header.height;
      const uint64_t pixels = uint64_t(header.width) * header.height;
      if (header.format == ImageFormat::kUnknown || pixels == 0) {
        scene_.warnings.push_back(image.name + ": neither a PNG nor a JPEG; its textures are left out");
      } else if (pixels > limits_.max_texture_pixels) {
        scene_.warnings.push_back(image.name + ": " + std::to_string(pixels) + " pixels, at most " +
                                  std::to_string(limits_.max_texture_pixels) + "; its textures are left out");
      } else {
        image.bytes = std::move(images[i]);
      }
      scene_.images.push_back(std::move(image));
    }
    for (const tinygltf::Texture& source : model_.textures) {
      Texture texture;
      texture.image = uint32_t(std::max(source.source, 0));
      if (source.sampler >= 0) {
        const tinygltf::Sampler& sampler = model_.samplers[size_t(source.sampler)];
        texture.wrap_s = ToWrap(sampler.wrapS);
        texture.wrap_t = ToWrap(sampler.wrapT);
        texture.is_nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
      }
      scene_.textures.push_back(texture);
    }
  }

  void BuildMaterial(const tinygltf::Material& source) {
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    Material material;
    material.name = source.name;
    for (int i = 0; i < 4; ++i) material.base_color[i] = float(pbr.baseColorFactor[size_t(i)]);
    const int texture = pbr.baseColorTexture.index;
    const bool has_image = texture >= 0 && model_.textures[size_t(texture)].source >= 0 &&
                           !scene_.images[scene_.textures[size_t(texture)].image].bytes.empty();
    material.base_color_texture = has_image ? texture : -1;
    material.metallic = float(pbr.metallicFactor);
    material.roughness = float(pbr.roughnessFactor);
    material.alpha_mode = source.alphaMode == "MASK"    ? AlphaMode::kMask
                          : source.alphaMode == "BLEND" ? AlphaMode::kBlend
                                                        : AlphaMode::kOpaque;
    material.alpha_cutoff = float(source.alphaCutoff);
    material.is_double_sided = source.doubleSided;
    scene_.materials.push_back(material);
  }

  absl::Status BuildMeshes() {
    for (size_t m = 0; m < model_.meshes.size(); ++m) {
      first_mesh_.push_back(uint32_t(scene_.meshes.size()));
      for (size_t p = 0; p < model_.meshes[m].primitives.size(); ++p) {
        RETURN_IF_ERROR(BuildPrimitive(model_.meshes[m].primitives[p],
                                       Pointer("meshes", m) + "/primitives/" + std::to_string(p)));
      }
      mesh_count_.push_back(uint32_t(scene_.meshes.size()) - first_mesh_.back());
    }
    return absl::OkStatus();
  }

  // Corner numbers of triangles, fans and strips as a list of triangles, in glTF's winding.
  absl::StatusOr<std::vector<uint32_t>> TriangleCorners(const tinygltf::Primitive& primitive, const std::string& pointer,
                                                        size_t vertex_count) const {
    std::vector<uint32_t> corners;
    if (primitive.indices >= 0) {
      const Elements elements(model_, primitive.indices);
      corners.resize(elements.count());
      for (size_t i = 0; i < corners.size(); ++i) {
        corners[i] = elements.Index(i);
        if (corners[i] >= vertex_count) {
          return absl::InvalidArgumentError(pointer + "/indices: element " + std::to_string(i) + " is " +
                                            std::to_string(corners[i]) + " (" +
                                            Pointer("accessors", size_t(primitive.indices)) + "); there are " +
                                            std::to_string(vertex_count) + " vertices");
        }
      }
    } else {
      corners.resize(vertex_count);
      for (size_t i = 0; i < vertex_count; ++i) corners[i] = uint32_t(i);
    }
    if (primitive.mode == TINYGLTF_MODE_TRIANGLES) {
      corners.resize(corners.size() / 3 * 3);
      return corners;
    }
    std::vector<uint32_t> list;
    for (size_t i = 0; i + 2 < corners.size(); ++i) {
      if (primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN) {
        list.insert(list.end(), {corners[i + 1], corners[i + 2], corners[0]});
      } else {
        const bool is_odd = i % 2 == 1;
        list.insert(list.end(), {corners[i], corners[i + (is_odd ? 2 : 1)], corners[i + (is_odd ? 1 : 2)]});
      }
    }
    return list;
  }

  absl::Status BuildPrimitive(const tinygltf::Primitive& primitive, const std::string& pointer) {
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end() || primitive.mode < TINYGLTF_MODE_TRIANGLES) return absl::OkStatus();
    const Elements positions(model_, position->second);
    Box3d bounds;
    for (size_t i = 0; i < positions.count(); ++i) {
      const glm::vec3 p = positions.Vector<glm::vec3>(i);
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
        return absl::InvalidArgumentError(pointer + "/attributes/POSITION: element " + std::to_string(i) +
                                          " is not finite (" + Pointer("accessors", size_t(position->second)) + ")");
      }
      bounds.Add(p);
    }
    ASSIGN_OR_RETURN(const std::vector<uint32_t> corners, TriangleCorners(primitive, pointer, positions.count()));
    Mesh mesh;
    mesh.origin = bounds.Center();
    mesh.first_vertex = uint32_t(scene_.positions.size());
    mesh.vertex_count = uint32_t(positions.count());
    mesh.first_index = uint32_t(scene_.indices.size());
    mesh.material = primitive.material >= 0 ? uint32_t(primitive.material) : uint32_t(scene_.materials.size() - 1);
    for (size_t i = 0; i < positions.count(); ++i) {
      const glm::vec3 local(glm::dvec3(positions.Vector<glm::vec3>(i)) - mesh.origin);
      scene_.positions.push_back(local);
      mesh.bounds.Add(local);
    }
    RETURN_IF_ERROR(BuildAttributes(primitive, pointer, positions.count()));
    for (size_t i = 0; i < corners.size(); i += 3) {
      if (HasArea(mesh, &corners[i])) {
        scene_.indices.insert(scene_.indices.end(), &corners[i], &corners[i] + 3);
      } else {
        ++scene_.degenerate_triangles_dropped;
      }
    }
    mesh.index_count = uint32_t(scene_.indices.size()) - mesh.first_index;
    if (scene_.indices.size() / 3 > limits_.max_triangles) {
      return absl::InvalidArgumentError(pointer + ": the scene has over " + std::to_string(limits_.max_triangles) +
                                        " triangles, the limit");
    }
    BuildClusters(&mesh);
    scene_.meshes.push_back(mesh);
    return absl::OkStatus();
  }

  absl::Status BuildAttributes(const tinygltf::Primitive& primitive, const std::string& pointer, size_t count) {
    const auto normal = primitive.attributes.find("NORMAL");
    const auto texcoord = primitive.attributes.find("TEXCOORD_0");
    const bool has_normals = normal != primitive.attributes.end();
    const bool has_texcoords = texcoord != primitive.attributes.end();
    for (size_t i = 0; i < count; ++i) {
      glm::vec3 n(0);
      if (has_normals) {
        n = Elements(model_, normal->second).Vector<glm::vec3>(i);
        const float length = glm::length(n);
        // A normal that is none shades with the geometric one.
        n = std::isfinite(length) && length > 0 ? n / length : glm::vec3(0);
      }
      glm::vec2 uv(0);
      if (has_texcoords) {
        uv = Elements(model_, texcoord->second).Vector<glm::vec2>(i);
        if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) {
          return absl::InvalidArgumentError(pointer + "/attributes/TEXCOORD_0: element " + std::to_string(i) +
                                            " is not finite");
        }
      }
      scene_.normals.push_back(n);
      scene_.texcoords.push_back(uv);
    }
    return absl::OkStatus();
  }

  bool HasArea(const Mesh& mesh, const uint32_t* corner) const {
    const glm::vec3* p = &scene_.positions[mesh.first_vertex];
    const glm::dvec3 a(p[corner[0]]), b(p[corner[1]]), c(p[corner[2]]);
    return glm::length(glm::cross(b - a, c - a)) > 0;
  }

  void BuildClusters(Mesh* mesh) {
    mesh->first_cluster = uint32_t(scene_.clusters.size());
    for (uint32_t first = 0; first < mesh->TriangleCount(); first += Cluster::kMaxTriangles) {
      Cluster cluster;
      cluster.first_triangle = first;
      cluster.triangle_count = std::min(Cluster::kMaxTriangles, mesh->TriangleCount() - first);
      for (uint32_t i = 3 * first; i < 3 * (first + cluster.triangle_count); ++i) {
        cluster.bounds.Add(scene_.positions[mesh->first_vertex + scene_.indices[mesh->first_index + i]]);
      }
      scene_.clusters.push_back(cluster);
    }
    mesh->cluster_count = uint32_t(scene_.clusters.size()) - mesh->first_cluster;
  }

  static glm::dmat4 LocalMatrix(const tinygltf::Node& node) {
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

  absl::Status BuildNodes() {
    for (const tinygltf::Node& source : model_.nodes) {
      Node node;
      node.name = source.name;
      node.local = LocalMatrix(source);
      if (source.mesh >= 0) {
        node.first_mesh = first_mesh_[size_t(source.mesh)];
        node.mesh_count = mesh_count_[size_t(source.mesh)];
      }
      node.camera = source.camera;
      scene_.nodes.push_back(node);
    }
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
      for (const int child : model_.nodes[i].children) scene_.nodes[size_t(child)].parent = int32_t(i);
    }
    return CheckWorldIsFinite();
  }

  // Matrices multiply along a chain: each may be finite and the product not.
  absl::Status CheckWorldIsFinite() const {
    std::vector<std::vector<uint32_t>> children(scene_.nodes.size());
    std::vector<std::pair<uint32_t, glm::dmat4>> stack;
    for (uint32_t i = 0; i < scene_.nodes.size(); ++i) {
      if (scene_.nodes[i].parent >= 0) {
        children[size_t(scene_.nodes[i].parent)].push_back(i);
      } else {
        stack.emplace_back(i, glm::dmat4(1));
      }
    }
    while (!stack.empty()) {
      const auto [node, world_from_parent] = stack.back();
      stack.pop_back();
      const glm::dmat4 world = world_from_parent * scene_.nodes[node].local;
      for (int i = 0; i < 16; ++i) {
        if (!(std::abs(glm::value_ptr(world)[i]) <= 1e30)) {
          return absl::InvalidArgumentError(Pointer("nodes", node) + ": its world matrix leaves the range of +-1e30");
        }
      }
      for (const uint32_t child : children[node]) stack.emplace_back(child, world);
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

  const tinygltf::Model& model_;
  const SceneLoadLimits& limits_;
  FlatScene scene_;
  std::vector<uint32_t> first_mesh_, mesh_count_;
};

}  // namespace

absl::StatusOr<FlatScene> BuildFlatScene(const tinygltf::Model& model, std::vector<std::string> images,
                                         std::vector<std::string> warnings, const SceneLoadLimits& limits) {
  return Builder(model, limits).Build(std::move(images), std::move(warnings));
}

}  // namespace halfshade
