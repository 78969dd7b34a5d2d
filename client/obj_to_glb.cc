#include "client/obj_to_glb.h"

#include <tiny_obj_loader.h>

#include <cmath>
#include <exception>
#include <map>
#include <tuple>

#include "client/glb_writer.h"

namespace halfshade {
namespace {

// OBJ indexes positions, normals and texture coordinates apart, glTF together.
class MeshBuilder {
 public:
  explicit MeshBuilder(const tinyobj::attrib_t& attributes) : attributes_(attributes) {}

  void AddCorner(const tinyobj::index_t& corner) {
    const auto key = std::make_tuple(corner.vertex_index, corner.normal_index, corner.texcoord_index);
    const auto [vertex, is_new] = vertices_.try_emplace(key, uint32_t(mesh_.positions.size()));
    if (is_new) {
      mesh_.positions.push_back(Vec3(attributes_.vertices, corner.vertex_index));
      mesh_.normals.push_back(corner.normal_index < 0 ? glm::vec3(0) : Vec3(attributes_.normals, corner.normal_index));
      has_all_normals_ = has_all_normals_ && corner.normal_index >= 0 && glm::length(mesh_.normals.back()) > 0;
      if (has_all_normals_) mesh_.normals.back() = glm::normalize(mesh_.normals.back());
      glm::vec2 uv(0);
      if (corner.texcoord_index >= 0) {
        const size_t at = 2 * size_t(corner.texcoord_index);
        uv = {attributes_.texcoords[at], 1 - attributes_.texcoords[at + 1]};
      }
      mesh_.texcoords.push_back(uv);
    }
    mesh_.indices.push_back(vertex->second);
  }

  GlbMesh Take(const std::string& name) {
    mesh_.name = name;
    mesh_.is_double_sided = true;  // OBJ says nothing of sides
    if (!has_all_normals_) SmoothNormals();
    return std::move(mesh_);
  }

 private:
  // Without normals of its own a scan looks smooth, not faceted: the mean of the faces around each vertex, by area.
  void SmoothNormals() {
    std::vector<glm::dvec3> sums(mesh_.positions.size(), glm::dvec3(0));
    for (size_t i = 0; i < mesh_.indices.size(); i += 3) {
      const uint32_t* corner = &mesh_.indices[i];
      const glm::dvec3 a(mesh_.positions[corner[0]]), b(mesh_.positions[corner[1]]), c(mesh_.positions[corner[2]]);
      for (int k = 0; k < 3; ++k) sums[corner[k]] += glm::cross(b - a, c - a);
    }
    for (size_t i = 0; i < sums.size(); ++i) {
      const double length = glm::length(sums[i]);
      mesh_.normals[i] = length > 0 ? glm::vec3(sums[i] / length) : glm::vec3(0);
    }
  }

  static glm::vec3 Vec3(const std::vector<tinyobj::real_t>& values, int index) {
    const size_t at = 3 * size_t(index);
    return {values[at], values[at + 1], values[at + 2]};
  }

  const tinyobj::attrib_t& attributes_;
  std::map<std::tuple<int, int, int>, uint32_t> vertices_;
  bool has_all_normals_ = true;
  GlbMesh mesh_;
};

}  // namespace

absl::StatusOr<std::string> ObjToGlb(const std::string& path) {
  tinyobj::ObjReaderConfig config;
  config.triangulate = true;
  tinyobj::ObjReader reader;
  try {
    if (!reader.ParseFromFile(path, config)) {
      return absl::InvalidArgumentError(path + ": " + (reader.Error().empty() ? "no OBJ file" : reader.Error()));
    }
  } catch (const std::exception& exception) {
    return absl::InvalidArgumentError(path + ": " + exception.what());
  }
  const tinyobj::attrib_t& attributes = reader.GetAttrib();
  for (const tinyobj::real_t value : attributes.vertices) {
    if (!std::isfinite(value)) return absl::InvalidArgumentError(path + ": a vertex is not finite");
  }
  std::vector<GlbMesh> meshes;
  for (const tinyobj::shape_t& shape : reader.GetShapes()) {
    std::map<int, MeshBuilder> builders;  // by material
    size_t corner = 0;
    for (size_t face = 0; face < shape.mesh.num_face_vertices.size(); ++face) {
      const size_t corners = shape.mesh.num_face_vertices[face];
      if (corners == 3) {
        MeshBuilder& builder = builders.try_emplace(shape.mesh.material_ids[face], attributes).first->second;
        for (size_t i = 0; i < 3; ++i) builder.AddCorner(shape.mesh.indices[corner + i]);
      }
      corner += corners;
    }
    for (auto& [material, builder] : builders) {
      meshes.push_back(builder.Take(shape.name));
      if (material < 0) continue;
      const tinyobj::material_t& source = reader.GetMaterials()[size_t(material)];
      meshes.back().base_color = {source.diffuse[0], source.diffuse[1], source.diffuse[2], 1};
    }
  }
  if (meshes.empty()) return absl::InvalidArgumentError(path + ": has no triangles");
  return WriteGlb(meshes);
}

}  // namespace halfshade
