#include "client/obj_to_glb.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <tuple>

#include "client/glb_writer.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;

// Opens what mtllib names if it is a regular file inside the OBJ's folder, links resolved. An absent one leaves the
// model grey, as tinyobjloader does; one outside is a fault.
class FolderMaterials : public tinyobj::MaterialReader {
 public:
  explicit FolderMaterials(const fs::path& folder) : folder_(fs::weakly_canonical(folder)) {}

  bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                  std::map<std::string, int>* numbers, std::string* warning, std::string* error) override {
    std::error_code failure;
    const fs::path path = fs::weakly_canonical(folder_ / name, failure);
    if (failure || std::mismatch(folder_.begin(), folder_.end(), path.begin(), path.end()).first != folder_.end()) {
      status_ = absl::InvalidArgumentError("mtllib " + name.substr(0, 200) + ": outside the OBJ's folder");
      return false;
    }
    if (!fs::is_regular_file(path, failure)) return false;
    std::ifstream file(path);
    return tinyobj::MaterialStreamReader(file)(name, materials, numbers, warning, error);
  }

  const absl::Status& status() const { return status_; }

 private:
  fs::path folder_;
  absl::Status status_;
};

struct Obj {
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
};

absl::StatusOr<Obj> ReadObj(const std::string& path) {
  Obj obj;
  std::string warning, error;
  try {
    if (!fs::is_regular_file(path)) return absl::InvalidArgumentError("no regular file");
    std::ifstream file(path);
    FolderMaterials materials(fs::absolute(path).parent_path());
    const bool is_read =
        tinyobj::LoadObj(&obj.attributes, &obj.shapes, &obj.materials, &warning, &error, &file, &materials,
                         /*triangulate=*/true, /*default_vcols_fallback=*/false);
    RETURN_IF_ERROR(materials.status());
    if (!is_read) return absl::InvalidArgumentError(error.empty() ? "no OBJ file" : error);
  } catch (const std::exception& exception) {
    return absl::InvalidArgumentError(exception.what());
  }
  for (const auto* values : {&obj.attributes.vertices, &obj.attributes.normals, &obj.attributes.texcoords}) {
    for (const tinyobj::real_t value : *values) {
      if (!std::isfinite(value)) return absl::InvalidArgumentError("a coordinate is not finite");
    }
  }
  return obj;
}

// tinyobjloader only warns of these.
absl::Status CheckCorner(const tinyobj::attrib_t& attributes, const tinyobj::index_t& corner) {
  const auto is_in = [](int index, size_t values, size_t size) { return index < int64_t(values / size); };
  if (corner.vertex_index >= 0 && is_in(corner.vertex_index, attributes.vertices.size(), 3) &&
      is_in(corner.normal_index, attributes.normals.size(), 3) &&
      is_in(corner.texcoord_index, attributes.texcoords.size(), 2)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError("a face names " + std::to_string(int64_t(corner.vertex_index) + 1) + "/" +
                                    std::to_string(int64_t(corner.texcoord_index) + 1) + "/" +
                                    std::to_string(int64_t(corner.normal_index) + 1) + ", which the file lacks");
}

// OBJ indexes positions, normals and texture coordinates apart, glTF together.
class MeshBuilder {
 public:
  explicit MeshBuilder(const tinyobj::attrib_t& attributes) : attributes_(attributes) {}

  void AddCorner(const tinyobj::index_t& corner) {
    const auto key = std::make_tuple(corner.vertex_index, corner.normal_index, corner.texcoord_index);
    const auto [vertex, is_new] = vertices_.try_emplace(key, uint32_t(mesh_.positions.size()));
    if (is_new) {
      mesh_.positions.push_back(Vec3(attributes_.vertices, corner.vertex_index));
      const glm::vec3 normal = corner.normal_index < 0 ? glm::vec3(0) : Vec3(attributes_.normals, corner.normal_index);
      const float length = glm::length(normal);
      has_all_normals_ = has_all_normals_ && length > 0;
      mesh_.normals.push_back(length > 0 ? normal / length : glm::vec3(0));
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

absl::StatusOr<std::vector<GlbMesh>> BuildMeshes(const Obj& obj) {
  std::vector<GlbMesh> meshes;
  for (const tinyobj::shape_t& shape : obj.shapes) {
    std::map<int, MeshBuilder> builders;  // by material
    size_t first = 0;
    for (size_t face = 0; face < shape.mesh.num_face_vertices.size(); ++face) {
      const size_t corners = shape.mesh.num_face_vertices[face];
      if (corners == 3) {
        MeshBuilder& builder = builders.try_emplace(shape.mesh.material_ids[face], obj.attributes).first->second;
        for (size_t i = first; i < first + 3; ++i) {
          RETURN_IF_ERROR(CheckCorner(obj.attributes, shape.mesh.indices[i]));
          builder.AddCorner(shape.mesh.indices[i]);
        }
      }
      first += corners;
    }
    for (auto& [material, builder] : builders) {
      meshes.push_back(builder.Take(shape.name));
      if (material < 0) continue;
      const tinyobj::real_t* diffuse = obj.materials[size_t(material)].diffuse;
      for (int i = 0; i < 3; ++i) meshes.back().base_color[i] = std::clamp(diffuse[i], 0.0f, 1.0f);
    }
  }
  if (meshes.empty()) return absl::InvalidArgumentError("has no triangles");
  size_t bytes = 0;
  for (const GlbMesh& mesh : meshes) {
    bytes += mesh.positions.size() * (2 * sizeof(glm::vec3) + sizeof(glm::vec2)) + mesh.indices.size() * 4;
  }
  if (bytes > kMaxGlbBytes) return absl::InvalidArgumentError("too large for a GLB, whose lengths have 32 bits");
  return meshes;
}

}  // namespace

absl::StatusOr<std::string> ObjToGlb(const std::string& path) {
  const absl::StatusOr<Obj> obj = ReadObj(path);
  if (!obj.ok()) return absl::InvalidArgumentError(path + ": " + std::string(obj.status().message()));
  const absl::StatusOr<std::vector<GlbMesh>> meshes = BuildMeshes(*obj);
  if (!meshes.ok()) return absl::InvalidArgumentError(path + ": " + std::string(meshes.status().message()));
  return WriteGlb(*meshes);
}

}  // namespace halfshade
