#include "renderer/scene/deform.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "renderer/scene/pose.h"

namespace halfshade {
namespace {

glm::dvec3 Unit(const glm::dvec3& vector) {
  const double length = glm::length(vector);
  return std::isfinite(length) && length > 0 ? vector / length : glm::dvec3(0);
}

// The inverse transpose but for its scale, which a unit normal does not need; a mirror's sign stays.
glm::dmat3 NormalMatrix(const glm::dmat3& m) {
  const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  return glm::determinant(m) < 0 ? -cofactors : cofactors;
}

struct Bent {
  glm::dvec3 position, normal, tangent;
};

class Bender {
 public:
  Bender(const FlatScene& scene, const Deformed& deformed, const std::vector<float>& morph_weights,
         const std::vector<glm::dmat4>& world_from_node)
      : scene_(scene), deformed_(deformed), vertex_count_(scene.meshes[deformed.mesh].vertex_count) {
    const Node& node = scene.nodes[deformed.node];
    for (uint32_t t = 0; t < deformed.target_count; ++t) {
      const double weight = morph_weights[node.first_weight + t];
      if (weight != 0) targets_.push_back({t, weight});
    }
    if (node.skin < 0) return;
    const Skin& skin = scene.skins[size_t(node.skin)];
    for (uint32_t j = skin.first_joint; j < skin.first_joint + skin.joint_count; ++j) {
      world_from_mesh_.push_back(world_from_node[scene.skin_joints[j]] * glm::dmat4(scene.joint_from_mesh[j]));
    }
  }

  Bent At(uint32_t vertex) const {
    const BindVertex& bind = scene_.bind_vertices[deformed_.first_bind + vertex];
    Bent bent{bind.position, bind.normal, bind.tangent};
    for (const Target& target : targets_) {
      const MorphDelta& delta =
          scene_.morph_deltas[deformed_.first_delta + size_t(target.index) * vertex_count_ + vertex];
      bent.position += target.weight * glm::dvec3(delta.position);
      bent.normal += target.weight * glm::dvec3(delta.normal);
      bent.tangent += target.weight * glm::dvec3(delta.tangent);
    }
    if (world_from_mesh_.empty()) return bent;
    glm::dmat4 blend(0);
    double total = 0;
    for (uint32_t i = 0; i < deformed_.influence_count; ++i) {
      const Influence& influence =
          scene_.influences[deformed_.first_influence + size_t(vertex) * deformed_.influence_count + i];
      if (influence.weight == 0) continue;
      blend += double(influence.weight) * world_from_mesh_[influence.joint];
      total += influence.weight;
    }
    // Nothing holds it: it goes with the first joint.
    blend = total > 0 ? blend / total : world_from_mesh_[0];
    const glm::dmat3 linear(blend);
    bent.position = glm::dvec3(blend * glm::dvec4(bent.position, 1));
    bent.normal = NormalMatrix(linear) * bent.normal;
    bent.tangent = linear * bent.tangent;
    return bent;
  }

 private:
  struct Target {
    uint32_t index;
    double weight;
  };
  const FlatScene& scene_;
  const Deformed& deformed_;
  const uint32_t vertex_count_;
  std::vector<Target> targets_;
  std::vector<glm::dmat4> world_from_mesh_;  // by joint of the skin
};

// The triangles that have an area as they are stored now, and the clusters of them.
void KeepTriangles(const Deformed& deformed, FlatScene* scene) {
  Mesh& mesh = scene->meshes[deformed.mesh];
  uint32_t* to = scene->indices.data() + mesh.first_index;
  for (uint32_t i = 0; i < deformed.bind_index_count; i += 3) {
    const uint32_t* corner = &scene->bind_indices[deformed.first_bind_index + i];
    glm::dvec3 p[3];
    for (int k = 0; k < 3; ++k) p[k] = scene->positions[mesh.first_vertex + corner[k]];
    if (glm::length(glm::cross(p[1] - p[0], p[2] - p[0])) > 0) to = std::copy(corner, corner + 3, to);
  }
  mesh.index_count = uint32_t(to - (scene->indices.data() + mesh.first_index));
  mesh.cluster_count = (mesh.TriangleCount() + Cluster::kMaxTriangles - 1) / Cluster::kMaxTriangles;
  for (uint32_t c = 0; c < mesh.cluster_count; ++c)
    scene->clusters[mesh.first_cluster + c] = scene->MakeCluster(mesh, c);
}

absl::Status DeformMesh(const Deformed& deformed, const Bender& bender, FlatScene* scene) {
  Mesh& mesh = scene->meshes[deformed.mesh];
  std::vector<glm::dvec3> positions(mesh.vertex_count);
  Box3d bounds;
  for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
    const Bent bent = bender.At(v);
    positions[v] = bent.position;
    for (int i = 0; i < 3; ++i) {
      if (std::abs(bent.position[i]) <= kMaxCoordinateM) continue;
      return absl::InvalidArgumentError("/nodes/" + std::to_string(deformed.node) +
                                        ": its mesh as it is bent reaches over 1e18 m away");
    }
    bounds.Add(bent.position);
    const uint32_t at = mesh.first_vertex + v;
    scene->normals[at] = glm::vec3(Unit(bent.normal));
    const glm::dvec3 tangent = Unit(bent.tangent);
    if (scene->tangents.empty()) continue;
    const float sign = scene->bind_vertices[deformed.first_bind + v].tangent.w;
    scene->tangents[at] = tangent == glm::dvec3(0) ? glm::vec4(0) : glm::vec4(tangent, sign);
  }
  mesh.origin = bounds.Center();
  mesh.bounds = {};
  for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
    const glm::vec3 local(positions[v] - mesh.origin);
    scene->positions[mesh.first_vertex + v] = local;
    mesh.bounds.Add(local);
  }
  KeepTriangles(deformed, scene);
  return absl::OkStatus();
}

}  // namespace

std::vector<bool> BendingNodes(const FlatScene& scene) {
  std::vector<bool> bends(scene.nodes.size(), false);
  for (const uint32_t joint : scene.skin_joints) {
    for (int32_t at = int32_t(joint); at >= 0 && !bends[size_t(at)]; at = scene.nodes[size_t(at)].parent) {
      bends[size_t(at)] = true;
    }
  }
  return bends;
}

void ForgetBinding(FlatScene* scene) {
  scene->deformed = {};
  scene->bind_vertices = {};
  scene->bind_indices = {};
  scene->influences = {};
  scene->morph_deltas = {};
}

absl::Status Deform(const std::vector<NodeOverride>& overrides, const std::vector<float>& morph_weights,
                    FlatScene* scene) {
  if (scene->deformed.empty()) return absl::OkStatus();
  const std::vector<glm::dmat4> world_from_node = WorldFromNodes(*scene, overrides);
  for (const Deformed& deformed : scene->deformed) {
    const Bender bender(*scene, deformed, morph_weights, world_from_node);
    if (absl::Status status = DeformMesh(deformed, bender, scene); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace halfshade
