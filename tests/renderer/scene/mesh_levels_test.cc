#include "renderer/scene/mesh_levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "tests/support/flat_scene_builder.h"
#include "tests/support/mesh_parts.h"

namespace halfshade {
namespace {

// Edges by their ends, and how often they are used from the first to the second more than the other way.
std::map<std::pair<uint32_t, uint32_t>, int> EdgeBalance(const std::vector<uint32_t>& indices) {
  std::map<std::pair<uint32_t, uint32_t>, int> balance;
  for (size_t i = 0; i < indices.size(); ++i) {
    const uint32_t a = indices[i], b = indices[i - i % 3 + (i + 1) % 3];
    balance[std::minmax(a, b)] += a < b ? 1 : -1;
  }
  return balance;
}

GlbMesh MakeBall(int rings) {
  GlbMesh ball;
  AddStarSolid(ball, {0, 0, 0}, rings, [](const glm::dvec3&) { return 1.0; });
  return ball;
}

TEST(MeshLevelsTest, ASphereHasEverFewerTrianglesWithinTheErrorThatIsSaid) {
  const FlatScene scene = MakeFlatScene({MakeBall(80)});
  const std::vector<MeshLevel> levels = BuildMeshLevels(scene, scene.meshes[0]);
  ASSERT_GE(levels.size(), 2u);
  size_t count = scene.meshes[0].index_count;
  float error = 0;
  for (const MeshLevel& level : levels) {
    EXPECT_LE(level.indices.size(), 0.6 * double(count));
    EXPECT_GT(level.error, error);
    count = level.indices.size();
    error = level.error;
    for (const auto& [edge, balance] : EdgeBalance(level.indices)) {
      EXPECT_EQ(balance, 0) << "a closed surface stays closed: edge " << edge.first << " " << edge.second;
    }
    double furthest = 0;  // of the triangles' middles below the sphere
    for (size_t i = 0; i < level.indices.size(); i += 3) {
      glm::dvec3 middle(0);
      for (size_t k = i; k < i + 3; ++k) middle += glm::dvec3(scene.positions[level.indices[k]]) / 3.0;
      furthest = std::max(furthest, 1 - glm::length(middle));
    }
    // A quadric is the mean over planes that a vertex stood in: less than the largest distance.
    EXPECT_LE(furthest, 3 * level.error);
    EXPECT_GE(furthest, level.error / 3);
  }
}

TEST(MeshLevelsTest, EdgesOfOneSideAloneKeepTheirVertices) {
  // A sphere without its lower half.
  GlbMesh dome = MakeBall(80);
  std::vector<uint32_t> upper;
  for (size_t i = 0; i < dome.indices.size(); i += 3) {
    const auto is_above = [&](size_t k) { return dome.positions[dome.indices[k]].y > 0; };
    if (is_above(i) && is_above(i + 1) && is_above(i + 2)) {
      upper.insert(upper.end(), dome.indices.begin() + long(i), dome.indices.begin() + long(i) + 3);
    }
  }
  dome.indices = upper;
  const FlatScene scene = MakeFlatScene({dome});
  const std::vector<MeshLevel> levels = BuildMeshLevels(scene, scene.meshes[0]);
  ASSERT_FALSE(levels.empty());
  const auto border = [&](const std::vector<uint32_t>& indices) {
    std::vector<glm::vec3> ends;
    for (const auto& [edge, balance] : EdgeBalance(indices)) {
      if (balance == 0) continue;
      for (const uint32_t vertex : {edge.first, edge.second}) ends.push_back(scene.positions[vertex]);
    }
    std::sort(ends.begin(), ends.end(),
              [](const glm::vec3& a, const glm::vec3& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); });
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    return ends;
  };
  const std::vector<glm::vec3> whole = border(levels[0].indices);
  EXPECT_GT(whole.size(), 50u);
  EXPECT_EQ(border(levels.back().indices), whole);
}

TEST(MeshLevelsTest, FewTrianglesAndLeavesHaveNoLevels) {
  std::vector<GlbMesh> meshes = {MakeBall(20), MakePlate({0, 0, 0}, 1, 1)};
  const size_t vertices = meshes[1].positions.size();
  for (int i = 1; i < 3000; ++i) {
    for (size_t k = 0; k < vertices; ++k) {
      meshes[1].positions.push_back(meshes[1].positions[k] + glm::vec3(0, i, 0));
      if (!meshes[1].normals.empty()) meshes[1].normals.push_back(glm::vec3(meshes[1].normals[k]));
    }
    for (size_t k = 0; k < 6; ++k) meshes[1].indices.push_back(meshes[1].indices[k] + uint32_t(i * vertices));
  }
  const FlatScene scene = MakeFlatScene(meshes);
  ASSERT_EQ(scene.meshes.size(), 2u);
  for (const Mesh& mesh : scene.meshes) EXPECT_TRUE(BuildMeshLevels(scene, mesh).empty());
}

}  // namespace
}  // namespace halfshade
