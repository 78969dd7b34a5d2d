#include "renderer/scene/mesh_levels.h"

#include <meshoptimizer.h>

#include <span>

#include "renderer/scene/weld.h"

namespace halfshade {
namespace {

// Below so many triangles a mesh is drawn as it is.
constexpr uint32_t kDenseTriangles = 4096;
// And a level's triangles are at least so many.
constexpr size_t kLeastTriangles = 200;
constexpr size_t kReduction = 4;
// A level that has more of the one before's triangles than this is not worth its memory.
constexpr double kLeastGain = 0.6;
constexpr float kMostError = 1.0f / 32;  // of the extent

}  // namespace

std::vector<MeshLevel> BuildMeshLevels(const FlatScene& scene, const Mesh& mesh) {
  if (mesh.TriangleCount() < kDenseTriangles || scene.CoverageOf(mesh) != MaskCoverage::kFull) return {};
  const std::span<const glm::vec3> positions(&scene.positions[mesh.first_vertex], mesh.vertex_count);
  const std::vector<uint32_t> welded = WeldPositions(positions);
  std::vector<uint32_t> indices;
  indices.reserve(mesh.index_count);
  for (uint32_t i = 0; i < mesh.index_count; i += 3) {
    const uint32_t* corner = &scene.indices[mesh.first_index + i];
    const uint32_t a = welded[corner[0]], b = welded[corner[1]], c = welded[corner[2]];
    if (a != b && b != c && c != a) indices.insert(indices.end(), {a, b, c});
  }
  const float scale = meshopt_simplifyScale(&positions[0].x, positions.size(), sizeof(glm::vec3));
  std::vector<MeshLevel> levels;
  float error = 0;
  while (indices.size() >= 3 * kLeastTriangles * kReduction) {
    std::vector<uint32_t> fewer(indices.size());
    float more_error = 0;
    fewer.resize(meshopt_simplify(fewer.data(), indices.data(), indices.size(), &positions[0].x, positions.size(),
                                  sizeof(glm::vec3), indices.size() / kReduction, kMostError,
                                  meshopt_SimplifyLockBorder, &more_error));
    if (double(fewer.size()) > kLeastGain * double(indices.size())) break;
    error += more_error * scale;
    fewer.shrink_to_fit();
    levels.push_back({fewer, error});
    indices = std::move(fewer);
  }
  return levels;
}

}  // namespace halfshade
