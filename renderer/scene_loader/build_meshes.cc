#include "renderer/scene_loader/build_meshes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "renderer/scene/pose.h"
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

  TexcoordSources sources;

  Attributes(const GltfData& data, const tinygltf::Primitive& primitive, const Material& material,
             const TexcoordSources& texcoord_sources)
      : sources(texcoord_sources) {
    const auto find = [&](const std::string& name, std::optional<AccessorReader>* reader) {
      const auto attribute = primitive.attributes.find(name);
      if (attribute != primitive.attributes.end()) reader->emplace(data, attribute->second);
    };
    find("NORMAL", &normals);
    find("TEXCOORD_" + std::to_string(sources[0].set), &texcoords);
    if (sources[1].is_used) find("TEXCOORD_" + std::to_string(sources[1].set), &texcoords1);
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
                                   const tinygltf::Primitive& primitive, const std::string& pointer,
                                   const TexcoordSource& source) {
  if (!reader) return glm::vec2(0);
  const glm::vec2 texcoord(source.transform * glm::dvec3(reader->Vector<glm::vec2>(vertex), 1));
  if (std::isfinite(texcoord.x) && std::isfinite(texcoord.y)) return texcoord;
  const std::string name = "TEXCOORD_" + std::to_string(source.set);
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

void MeshBuilder::AddTriangles(const Corners& corners, const AccessorReader& positions, const glm::dvec3& origin,
                               bool deforms) {
  for (size_t triangle = 0; triangle < corners.triangles(); ++triangle) {
    uint32_t vertex[3];
    glm::vec3 position[3];
    for (size_t corner = 0; corner < 3; ++corner) {
      vertex[corner] = corners.Vertex(triangle, corner);
      position[corner] = Local(positions, vertex[corner], origin);
    }
    // What is flat at rest need not be so when it is bent.
    const bool is_line = vertex[0] == vertex[1] || vertex[1] == vertex[2] || vertex[2] == vertex[0];
    if (deforms ? !is_line : HasArea(position[0], position[1], position[2])) {
      scene_.indices.insert(scene_.indices.end(), vertex, vertex + 3);
    } else {
      ++scene_.degenerate_triangles_dropped;
    }
  }
}

absl::StatusOr<std::vector<uint32_t>> MeshBuilder::AddVertices(const tinygltf::Primitive& primitive,
                                                               const AccessorReader& positions,
                                                               const std::string& pointer, Mesh* mesh) {
  const Attributes attributes(data_, primitive, scene_.materials[mesh->material], texcoords_[mesh->material]);
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
    ASSIGN_OR_RETURN(const glm::vec2 texcoord,
                     Texcoord(attributes.texcoords, used[slot], primitive, pointer, attributes.sources[0]));
    scene_.texcoords.push_back(texcoord);
    if (attributes.texcoords1) {
      ASSIGN_OR_RETURN(const glm::vec2 second,
                       Texcoord(attributes.texcoords1, used[slot], primitive, pointer, attributes.sources[1]));
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
  return used;
}

absl::Status MeshBuilder::AddDeformed(const tinygltf::Primitive& primitive, const std::string& pointer,
                                      const std::vector<uint32_t>& used, const DeformingNode& deforming,
                                      const Mesh& mesh) {
  Deformed deformed;
  deformed.node = deforming.node;
  deformed.mesh = uint32_t(scene_.meshes.size());
  deformed.first_bind = uint32_t(scene_.bind_vertices.size());
  deformed.first_bind_index = uint32_t(scene_.bind_indices.size());
  deformed.bind_index_count = mesh.index_count;
  deformed.first_influence = uint32_t(scene_.influences.size());
  deformed.first_delta = uint32_t(scene_.morph_deltas.size());
  deformed.target_count = uint32_t(primitive.targets.size());
  std::vector<std::pair<AccessorReader, AccessorReader>> sets;  // joints and weights
  for (int set = 0; deforming.has_skin; ++set) {
    const auto joints = primitive.attributes.find("JOINTS_" + std::to_string(set));
    const auto weights = primitive.attributes.find("WEIGHTS_" + std::to_string(set));
    if (joints == primitive.attributes.end() || weights == primitive.attributes.end()) break;
    sets.emplace_back(AccessorReader(data_, joints->second), AccessorReader(data_, weights->second));
  }
  if (deforming.has_skin && sets.empty()) {
    warnings_.Add(pointer + "/attributes", "without JOINTS_0 and WEIGHTS_0 it goes with its skin's first joint");
  }
  deformed.influence_count = uint32_t(4 * sets.size());
  const uint64_t bytes =
      (scene_.bind_vertices.size() + used.size()) * uint64_t(sizeof(BindVertex)) +
      (scene_.bind_indices.size() + mesh.index_count) * uint64_t(sizeof(uint32_t)) +
      (scene_.influences.size() + used.size() * deformed.influence_count) * uint64_t(sizeof(Influence)) +
      (scene_.morph_deltas.size() + used.size() * deformed.target_count) * uint64_t(sizeof(MorphDelta));
  if (bytes > limits_.max_scene_bytes) {
    return absl::InvalidArgumentError(pointer + ": skins and morph targets take over " +
                                      std::to_string(limits_.max_scene_bytes) + " bytes, the limit");
  }
  const AccessorReader positions(data_, primitive.attributes.at("POSITION"));
  const uint32_t* const first = scene_.indices.data() + mesh.first_index;
  scene_.bind_indices.insert(scene_.bind_indices.end(), first, first + mesh.index_count);
  for (uint32_t v = 0; v < used.size(); ++v) {
    const uint32_t at = mesh.first_vertex + v;
    BindVertex bind;
    bind.position = positions.Vector<glm::vec3>(used[v]);
    bind.normal = scene_.normals[at];
    if (!scene_.tangents.empty()) bind.tangent = scene_.tangents[at];
    scene_.bind_vertices.push_back(bind);
    for (const auto& [joints, weights] : sets) {
      const glm::vec4 weight = weights.Vector<glm::vec4>(used[v]);
      for (int i = 0; i < 4; ++i) {
        scene_.influences.push_back({joints.IndexAt(used[v], i), std::max(weight[i], 0.0f)});
      }
    }
  }
  for (const std::map<std::string, int>& target : primitive.targets) {
    std::optional<AccessorReader> moves, normals, tangents;
    const auto find = [&](const char* name, std::optional<AccessorReader>* reader) {
      const auto attribute = target.find(name);
      if (attribute != target.end()) reader->emplace(data_, attribute->second);
    };
    find("POSITION", &moves);
    find("NORMAL", &normals);
    find("TANGENT", &tangents);
    for (const uint32_t vertex : used) {
      MorphDelta delta;
      if (moves) delta.position = moves->Vector<glm::vec3>(vertex);
      if (normals) delta.normal = normals->Vector<glm::vec3>(vertex);
      if (tangents) delta.tangent = tangents->Vector<glm::vec3>(vertex);
      scene_.morph_deltas.push_back(delta);
    }
  }
  scene_.deformed.push_back(deformed);
  return absl::OkStatus();
}

void MeshBuilder::AddClusters(Mesh* mesh) {
  mesh->first_cluster = uint32_t(scene_.clusters.size());
  mesh->cluster_count = (mesh->TriangleCount() + Cluster::kMaxTriangles - 1) / Cluster::kMaxTriangles;
  for (uint32_t c = 0; c < mesh->cluster_count; ++c) scene_.clusters.push_back(scene_.MakeCluster(*mesh, c));
}

absl::Status MeshBuilder::Add(const tinygltf::Primitive& primitive, const std::string& pointer,
                              const DeformingNode* deforming) {
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
  AddTriangles(corners, positions, mesh.origin, deforming != nullptr);
  mesh.index_count = uint32_t(scene_.indices.size()) - mesh.first_index;
  if (mesh.index_count == 0) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::vector<uint32_t> used, AddVertices(primitive, positions, pointer, &mesh));
  const uint64_t bytes = scene_.positions.size() * uint64_t(2 * sizeof(glm::vec3) + sizeof(glm::vec2)) +
                         scene_.texcoords1.size() * uint64_t(sizeof(glm::vec2)) +
                         (scene_.tangents.size() + scene_.colors.size()) * uint64_t(sizeof(glm::vec4)) +
                         scene_.indices.size() * uint64_t(sizeof(uint32_t));
  if (bytes > limits_.max_scene_bytes) {
    return absl::InvalidArgumentError(pointer + ": the scene takes over " + std::to_string(limits_.max_scene_bytes) +
                                      " bytes, the limit");
  }
  AddClusters(&mesh);
  if (deforming != nullptr) RETURN_IF_ERROR(AddDeformed(primitive, pointer, used, *deforming, mesh));
  scene_.meshes.push_back(mesh);
  return absl::OkStatus();
}

}  // namespace halfshade
