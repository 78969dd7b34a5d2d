#include "renderer/shadow/shaft/topology.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/flat_scene_builder.h"

namespace halfshade {
namespace {

using testing::Each;

struct Triangles {
  std::vector<glm::vec3> positions;
  std::vector<uint32_t> indices;
};

// Every triangle with corners of its own, as a file with seams everywhere would have them.
Triangles Unwelded(const std::vector<GlbMesh>& meshes, bool is_turned = false) {
  const FlatScene scene = MakeFlatScene(meshes);
  Triangles triangles;
  for (const Mesh& mesh : scene.meshes) {
    for (uint32_t i = 0; i < mesh.index_count; ++i) {
      const uint32_t vertex = mesh.first_vertex + scene.indices[mesh.first_index + i];
      triangles.positions.push_back(glm::vec3(glm::dvec3(scene.positions[vertex]) + mesh.origin));
      triangles.indices.push_back(uint32_t(triangles.indices.size()));
    }
  }
  if (is_turned) std::reverse(triangles.indices.begin(), triangles.indices.end());
  return triangles;
}

Topology Find(const Triangles& triangles, float least_z = -100) {
  return FindTopology(triangles.positions, triangles.indices, least_z);
}

const GlbMesh kBox = MakeBox({0, 0, 5}, {1, 2, 1});

TEST(TopologyTest, ABoxIsClosedThoughNoTwoTrianglesShareAVertex) {
  const Topology topology = Find(Unwelded({kBox}));
  EXPECT_EQ(topology.closed.size(), 12u);
  EXPECT_THAT(topology.closed, Each(1));
  EXPECT_EQ(std::count(topology.neighbours.begin(), topology.neighbours.end(), kNoTriangle), 0);
}

TEST(TopologyTest, ABoxThatIsTurnedInsideOutIsKnownAsThat) {
  EXPECT_THAT(Find(Unwelded({kBox}, true)).closed, Each(2));
}

TEST(TopologyTest, ABoxWithoutOneTriangleIsOpen) {
  Triangles triangles = Unwelded({kBox});
  triangles.indices.resize(triangles.indices.size() - 3);
  EXPECT_THAT(Find(triangles).closed, Each(0));
}

TEST(TopologyTest, ABoxWithOneTriangleTurnedIsOpen) {
  Triangles triangles = Unwelded({kBox});
  std::swap(triangles.indices[0], triangles.indices[1]);
  EXPECT_THAT(Find(triangles).closed, Each(0));
}

TEST(TopologyTest, ABoxThatReachesTheLightsPlaneIsOpenAndOneBesideItIsNot) {
  const Topology topology = Find(Unwelded({MakeBox({0, 0, 0}, {1, 1, 1}), kBox}), 1e-3f);
  EXPECT_THAT(std::vector<uint8_t>(topology.closed.begin(), topology.closed.begin() + 12), Each(0));
  EXPECT_THAT(std::vector<uint8_t>(topology.closed.begin() + 12, topology.closed.end()), Each(1));
}

TEST(TopologyTest, TwoBoxesThatShareAnEdgeAreClosed) {
  const Topology topology = Find(Unwelded({MakeBox({0, 0, 5}, {1, 1, 1}), MakeBox({1, 1, 5}, {1, 1, 1})}));
  EXPECT_THAT(topology.closed, Each(1));
  EXPECT_GT(std::count(topology.neighbours.begin(), topology.neighbours.end(), kNoTriangle), 0)
      << "of the four at that edge none is the neighbour of another";
}

TEST(TopologyTest, AnOpenSheetBesideABoxLeavesItClosed) {
  const Topology topology = Find(Unwelded({MakePlate({0, 0, 2}, 3, 3), kBox}));
  EXPECT_EQ(std::count(topology.closed.begin(), topology.closed.end(), 1), 12);
  EXPECT_EQ(std::count(topology.closed.begin(), topology.closed.end(), 0), 2);
}

TEST(TopologyTest, TrianglesWithoutTwoOfTheirCornersAreNoNeighbours) {
  Triangles triangles = Unwelded({kBox});
  triangles.indices.insert(triangles.indices.end(), {0, 0, 1});
  const Topology topology = Find(triangles);
  EXPECT_THAT(std::vector<uint8_t>(topology.closed.begin(), topology.closed.begin() + 12), Each(1));
}

}  // namespace
}  // namespace halfshade
