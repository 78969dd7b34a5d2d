#include "tests/support/flat_scene_builder.h"

#include <algorithm>
#include <cmath>

namespace halfshade {
namespace {

void AddQuad(GlbMesh& mesh, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
  const uint32_t first = uint32_t(mesh.positions.size());
  for (const glm::dvec3& p : {a, b, c, d}) mesh.positions.emplace_back(p);
  for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + i);
}

}  // namespace

FlatScene MakeFlatScene(const std::vector<GlbMesh>& meshes) {
  FlatScene scene;
  SceneRoots roots;
  for (const GlbMesh& source : meshes) {
    Box3d bounds;
    for (const glm::vec3& p : source.positions) bounds.Add(p);
    Mesh mesh;
    mesh.origin = bounds.Center();
    mesh.first_vertex = uint32_t(scene.positions.size());
    mesh.vertex_count = uint32_t(source.positions.size());
    mesh.first_index = uint32_t(scene.indices.size());
    mesh.index_count = uint32_t(source.indices.size());
    mesh.first_cluster = uint32_t(scene.clusters.size());
    mesh.material = uint32_t(scene.materials.size());
    for (const glm::vec3& p : source.positions) {
      scene.positions.emplace_back(glm::dvec3(p) - mesh.origin);
      mesh.bounds.Add(scene.positions.back());
    }
    scene.indices.insert(scene.indices.end(), source.indices.begin(), source.indices.end());
    for (uint32_t first = 0; first < mesh.TriangleCount(); first += Cluster::kMaxTriangles) {
      Cluster cluster;
      cluster.first_triangle = first;
      cluster.triangle_count = std::min(Cluster::kMaxTriangles, mesh.TriangleCount() - first);
      for (uint32_t i = 3 * first; i < 3 * (first + cluster.triangle_count); ++i) {
        cluster.bounds.Add(scene.positions[mesh.first_vertex + source.indices[i]]);
      }
      scene.clusters.push_back(cluster);
    }
    mesh.cluster_count = uint32_t(scene.clusters.size()) - mesh.first_cluster;
    scene.normals.insert(scene.normals.end(), source.normals.begin(), source.normals.end());
    scene.texcoords.insert(scene.texcoords.end(), source.texcoords.begin(), source.texcoords.end());
    scene.normals.resize(scene.positions.size(), glm::vec3(0));
    scene.texcoords.resize(scene.positions.size(), glm::vec2(0));
    Material material;
    material.base_color = source.base_color;
    material.metallic = 0;  // as WriteGlb says
    material.is_double_sided = source.is_double_sided;
    scene.materials.push_back(material);
    Node node;
    node.name = source.name;
    node.local = source.world_from_mesh;
    node.first_mesh = uint32_t(scene.meshes.size());
    node.mesh_count = 1;
    roots.roots.push_back(uint32_t(scene.nodes.size()));
    scene.nodes.push_back(node);
    scene.meshes.push_back(mesh);
  }
  scene.materials.emplace_back();
  scene.scenes = {roots};
  return scene;
}

GlbMesh MakeSquare(const glm::dvec3& center, double size, double slope_rad) {
  const glm::dvec3 across = glm::dvec3(std::cos(slope_rad), std::sin(slope_rad), 0) * (size / 2);
  const glm::dvec3 along(0, 0, size / 2);
  GlbMesh mesh;
  AddQuad(mesh, center - across + along, center + across + along, center + across - along, center - across - along);
  mesh.is_double_sided = true;
  return mesh;
}

GlbMesh MakePlate(const glm::dvec3& center, double size_x, double size_z) {
  const glm::dvec3 x(size_x / 2, 0, 0), z(0, 0, size_z / 2);
  GlbMesh mesh;
  AddQuad(mesh, center - x + z, center + x + z, center + x - z, center - x - z);
  mesh.is_double_sided = true;
  return mesh;
}

GlbMesh MakeBox(const glm::dvec3& center, const glm::dvec3& size) {
  GlbMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      glm::dvec3 n(0), u(0), v(0);
      n[axis] = sign * size[axis] / 2;
      u[(axis + 1) % 3] = size[(axis + 1) % 3] / 2;
      v[(axis + 2) % 3] = sign * size[(axis + 2) % 3] / 2;
      AddQuad(mesh, center + n - u - v, center + n + u - v, center + n + u + v, center + n - u + v);
    }
  }
  return mesh;
}

GlbMesh MakeSphere(const glm::dvec3& center, double radius, int rings) {
  GlbMesh mesh;
  const int segments = 2 * rings;
  for (int ring = 0; ring <= rings; ++ring) {
    for (int segment = 0; segment <= segments; ++segment) {
      const double polar = M_PI * ring / rings;
      const double around = 2 * M_PI * segment / segments;
      const glm::dvec3 n(std::sin(polar) * std::cos(around), std::cos(polar), -std::sin(polar) * std::sin(around));
      mesh.positions.emplace_back(center + n * radius);
      mesh.normals.emplace_back(n);
    }
  }
  for (int ring = 0; ring < rings; ++ring) {
    for (int segment = 0; segment < segments; ++segment) {
      const uint32_t a = uint32_t(ring * (segments + 1) + segment);
      const uint32_t b = a + uint32_t(segments) + 1;
      if (ring > 0) mesh.indices.insert(mesh.indices.end(), {a, b, a + 1});
      if (ring < rings - 1) mesh.indices.insert(mesh.indices.end(), {a + 1, b, b + 1});
    }
  }
  return mesh;
}

}  // namespace halfshade
