#include "renderer/scene_loader/build_meshes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "renderer/scene_loader/tinygltf.h"
#include "renderer/status.h"

namespace halfshade {

// Lists, strips and fans as triangles of vertex numbers, in glTF's winding.
class MeshBuilder::Corners {
 public:
  Corners(const GltfData& data, const tinygltf::Primitive& primitive, size_t vertex_count) : mode_(primitive.mode) {
    if (primitive.indices >= 0) indices_.emplace(data, primitive.indices);
    const size_t count = indices_ ? indices_->count() : vertex_count;
    triangles_ = mode_ == TINYGLTF_MODE_TRIANGLES ? count / 3 : std::max<size_t>(count, 2) - 2;
  }

  size_t triangles() const { return triangles_; }

  // Where the corner 0, 1 or 2 of a triangle stands in the list of indices, or of vertices without them.
  size_t Element(size_t triangle, size_t corner) const {
    if (mode_ == TINYGLTF_MODE_TRIANGLES) return 3 * triangle + corner;
    if (mode_ == TINYGLTF_MODE_TRIANGLE_FAN) return corner == 2 ? 0 : triangle + 1 + corner;
    const size_t is_odd = triangle % 2;
    return corner == 0 ? triangle : corner == 1 ? triangle + 1 + is_odd : triangle + 2 - is_odd;
  }

  uint32_t Vertex(size_t triangle, size_t corner) const {
    const size_t element = Element(triangle, corner);
    return indices_ ? indices_->Index(element) : uint32_t(element);
  }

 private:
  int mode_;
  std::optional<AccessorReader> indices_;
  size_t triangles_ = 0;
};

namespace {

std::string AccessorOf(int accessor) { return "/accessors/" + std::to_string(accessor); }

glm::vec3 Local(const AccessorReader& positions, uint32_t vertex, const glm::dvec3& origin) {
  return glm::vec3(glm::dvec3(positions.Vector<glm::vec3>(vertex)) - origin);
}

// The attributes beside positions that a primitive has and its material asks for.
struct Attributes {
  std::optional<AccessorReader> normals, texcoords, texcoords1, tangents, colors;

  Attributes(const GltfData& data, const tinygltf::Primitive& primitive, const Material& material) {
    bool wants_second = false;
    for (const MaterialTexture* texture :
         {&material.base_color_texture, &material.metallic_roughness_texture, &material.normal_texture,
          &material.occlusion_texture, &material.emissive_texture}) {
      wants_second = wants_second || (texture->texture >= 0 && texture->texcoord == 1);
    }
    const auto find = [&](const char* name, std::optional<AccessorReader>* reader) {
      const auto attribute = primitive.attributes.find(name);
      if (attribute != primitive.attributes.end()) reader->emplace(data, attribute->second);
    };
    find("NORMAL", &normals);
    find("TEXCOORD_0", &texcoords);
    if (wants_second) find("TEXCOORD_1", &texcoords1);
    if (material.normal_texture.texture >= 0) find("TANGENT", &tangents);
    find("COLOR_0", &colors);
  }

  // Unit, or zero without a direction.
  glm::vec3 Normal(uint32_t vertex) const { return normals ? Unit(normals->Vector<glm::vec3>(vertex)) : glm::vec3(0); }
  glm::vec4 Tangent(uint32_t vertex) const {
    const glm::vec4 tangent = tangents->Vector<glm::vec4>(vertex);
    const glm::vec3 direction = Unit(glm::vec3(tangent));
    return direction == glm::vec3(0) ? glm::vec4(0) : glm::vec4(direction, tangent.w < 0 ? -1.0f : 1.0f);
  }
  glm::vec4 Color(uint32_t vertex) const {
    glm::vec4 color(1);
    for (int i = 0; i < colors->components(); ++i) color[i] = glm::clamp(colors->Float(vertex, i), 0.0f, 1.0f);
    return color;
  }

 private:
  static glm::vec3 Unit(const glm::vec3& vector) {
    const float length = glm::length(vector);
    return std::isfinite(length) && length > 0 ? vector / length : glm::vec3(0);
  }
};

absl::StatusOr<glm::vec2> Texcoord(const std::optional<AccessorReader>& reader, uint32_t vertex,
                                   const tinygltf::Primitive& primitive, const std::string& pointer, int set) {
  if (!reader) return glm::vec2(0);
  const glm::vec2 texcoord = reader->Vector<glm::vec2>(vertex);
  if (std::isfinite(texcoord.x) && std::isfinite(texcoord.y)) return texcoord;
  const std::string name = "TEXCOORD_" + std::to_string(set);
  return absl::InvalidArgumentError(pointer + "/attributes/" + name + ": element " + std::to_string(vertex) +
                                    " is not finite (" + AccessorOf(primitive.attributes.at(name)) + ")");
}

// Of the corners as they are stored, since those are drawn.
bool HasArea(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  return glm::length(glm::cross(b - a, c - a)) > 0;
}

}  // namespace

absl::StatusOr<Box3d> MeshBuilder::Measure(const tinygltf::Primitive& primitive, const Corners& corners,
                                           const AccessorReader& positions, const std::string& pointer) {
  Box3d bounds;
  for (size_t triangle = 0; triangle < corners.triangles(); ++triangle) {
    for (size_t corner = 0; corner < 3; ++corner) {
      const uint32_t vertex = corners.Vertex(triangle, corner);
      if (vertex >= positions.count()) {
        return absl::InvalidArgumentError(pointer + "/indices: element " +
                                          std::to_string(corners.Element(triangle, corner)) + " is " +
                                          std::to_string(vertex) + " (" + AccessorOf(primitive.indices) +
                                          "); there are " + std::to_string(positions.count()) + " vertices");
      }
      const glm::dvec3 position(positions.Vector<glm::vec3>(vertex));
      for (int i = 0; i < 3; ++i) {
        if (std::abs(position[i]) <= kMaxCoordinateM) continue;
        return absl::InvalidArgumentError(pointer + "/attributes/POSITION: element " + std::to_string(vertex) +
                                          (std::isfinite(position[i]) ? " is over 1e18 m away" : " is not finite") +
                                          " (" + AccessorOf(primitive.attributes.at("POSITION")) + ")");
      }
      bounds.Add(position);
    }
  }
  return bounds;
}

void MeshBuilder::AddTriangles(const Corners& corners, const AccessorReader& positions, const glm::dvec3& origin) {
  for (size_t triangle = 0; triangle < corners.triangles(); ++triangle) {
    uint32_t vertex[3];
    glm::vec3 position[3];
    for (size_t corner = 0; corner < 3; ++corner) {
      vertex[corner] = corners.Vertex(triangle, corner);
      position[corner] = Local(positions, vertex[corner], origin);
    }
    if (HasArea(position[0], position[1], position[2])) {
      scene_.indices.insert(scene_.indices.end(), vertex, vertex + 3);
    } else {
      ++scene_.degenerate_triangles_dropped;
    }
  }
}

absl::Status MeshBuilder::AddVertices(const tinygltf::Primitive& primitive, const AccessorReader& positions,
                                      const std::string& pointer, Mesh* mesh) {
  const Attributes attributes(data_, primitive, scene_.materials[mesh->material]);
  uint32_t* const first = scene_.indices.data() + mesh->first_index;
  uint32_t* const last = first + mesh->index_count;
  const size_t largest = *std::max_element(first, last);
  if (slots_.size() <= largest) slots_.resize(largest + 1);
  std::vector<uint32_t> used;
  for (uint32_t* index = first; index != last; ++index) {
    if (slots_[*index] != 0) continue;
    slots_[*index] = 1;
    used.push_back(*index);
  }
  std::sort(used.begin(), used.end());
  bool has_bad_normals = false;
  for (size_t slot = 0; slot < used.size(); ++slot) {
    slots_[used[slot]] = uint32_t(slot);
    const glm::vec3 local = Local(positions, used[slot], mesh->origin);
    mesh->bounds.Add(local);
    scene_.positions.push_back(local);
    const glm::vec3 normal = attributes.Normal(used[slot]);
    has_bad_normals = has_bad_normals || (attributes.normals && normal == glm::vec3(0));
    scene_.normals.push_back(normal);
    ASSIGN_OR_RETURN(const glm::vec2 texcoord, Texcoord(attributes.texcoords, used[slot], primitive, pointer, 0));
    scene_.texcoords.push_back(texcoord);
    if (attributes.texcoords1) {
      ASSIGN_OR_RETURN(const glm::vec2 second, Texcoord(attributes.texcoords1, used[slot], primitive, pointer, 1));
      scene_.texcoords1.resize(scene_.positions.size() - 1, glm::vec2(0));
      scene_.texcoords1.push_back(second);
    }
    if (attributes.tangents) {
      scene_.tangents.resize(scene_.positions.size() - 1, glm::vec4(0));
      scene_.tangents.push_back(attributes.Tangent(used[slot]));
    }
    if (attributes.colors) {
      scene_.colors.resize(scene_.positions.size() - 1, glm::vec4(1));
      scene_.colors.push_back(attributes.Color(used[slot]));
    }
  }
  if (has_bad_normals) {
    warnings_.Add(pointer + "/attributes/NORMAL", "normals without a direction; there the surface's own shades");
  }
  for (uint32_t* index = first; index != last; ++index) *index = slots_[*index];
  for (const uint32_t vertex : used) slots_[vertex] = 0;
  mesh->vertex_count = uint32_t(used.size());
  if (!scene_.texcoords1.empty()) scene_.texcoords1.resize(scene_.positions.size(), glm::vec2(0));
  if (!scene_.tangents.empty()) scene_.tangents.resize(scene_.positions.size(), glm::vec4(0));
  if (!scene_.colors.empty()) scene_.colors.resize(scene_.positions.size(), glm::vec4(1));
  return absl::OkStatus();
}

void MeshBuilder::AddClusters(Mesh* mesh) {
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

absl::Status MeshBuilder::Add(const tinygltf::Primitive& primitive, const std::string& pointer) {
  const auto attribute = primitive.attributes.find("POSITION");
  if (attribute == primitive.attributes.end() || primitive.mode < TINYGLTF_MODE_TRIANGLES) return absl::OkStatus();
  const AccessorReader positions(data_, attribute->second);
  const Corners corners(data_, primitive, positions.count());
  triangles_read_ += corners.triangles();
  if (triangles_read_ > limits_.max_triangles) {
    return absl::InvalidArgumentError(pointer + ": the scene has over " + std::to_string(limits_.max_triangles) +
                                      " triangles, the limit");
  }
  ASSIGN_OR_RETURN(const Box3d bounds, Measure(primitive, corners, positions, pointer));
  Mesh mesh;
  mesh.origin = bounds.Center();
  mesh.first_vertex = uint32_t(scene_.positions.size());
  mesh.first_index = uint32_t(scene_.indices.size());
  mesh.material = primitive.material >= 0 ? uint32_t(primitive.material) : uint32_t(scene_.materials.size() - 1);
  AddTriangles(corners, positions, mesh.origin);
  mesh.index_count = uint32_t(scene_.indices.size()) - mesh.first_index;
  if (mesh.index_count == 0) return absl::OkStatus();
  RETURN_IF_ERROR(AddVertices(primitive, positions, pointer, &mesh));
  const uint64_t bytes = scene_.positions.size() * uint64_t(2 * sizeof(glm::vec3) + sizeof(glm::vec2)) +
                         scene_.texcoords1.size() * uint64_t(sizeof(glm::vec2)) +
                         (scene_.tangents.size() + scene_.colors.size()) * uint64_t(sizeof(glm::vec4)) +
                         scene_.indices.size() * uint64_t(sizeof(uint32_t));
  if (bytes > limits_.max_scene_bytes) {
    return absl::InvalidArgumentError(pointer + ": the scene takes over " + std::to_string(limits_.max_scene_bytes) +
                                      " bytes, the limit");
  }
  AddClusters(&mesh);
  scene_.meshes.push_back(mesh);
  return absl::OkStatus();
}

}  // namespace halfshade
