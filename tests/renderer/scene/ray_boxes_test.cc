#include "renderer/scene/ray_boxes.h"

#include <gtest/gtest.h>

#include <random>

namespace halfshade {
namespace {

TEST(RayBoxesTest, AHalfSpaceHoldsTheBoxesWhereItHoldsTheTriangles) {
  std::mt19937 random(5);
  const auto uniform = [&](float low, float high) { return low + (high - low) * float(random() >> 8) / 16777216.0f; };
  for (const int triangles : {1, 7, 8, 9, 64, 65, 3000}) {
    std::vector<glm::vec4> vertices;
    std::vector<uint32_t> indices;
    for (int i = 0; i < triangles; ++i) {
      const glm::vec3 middle(uniform(-0.9f, 0.9f), uniform(-0.9f, 0.9f), uniform(-0.9f, 0.9f));
      for (int k = 0; k < 3; ++k) {
        indices.push_back(uint32_t(vertices.size()));
        vertices.emplace_back(middle + glm::vec3(uniform(-0.1f, 0.1f), uniform(-0.1f, 0.1f), uniform(-0.1f, 0.1f)), 0);
      }
    }
    const RayBoxes boxes(vertices, indices);
    EXPECT_GT(boxes.SizeBytes(), 0u);
    for (int axis = 0; axis < 3; ++axis) {
      float most = -1;
      for (const glm::vec4& vertex : vertices) most = std::max(most, vertex[axis]);
      EXPECT_TRUE(boxes.AreAllOutside([&](const Box3f& box) { return box.max[axis] <= most; })) << triangles;
      EXPECT_FALSE(boxes.AreAllOutside([&](const Box3f& box) { return box.max[axis] < most; })) << triangles;
    }
  }
}

TEST(RayBoxesTest, WhatHasNoVertexInCommonSharesNoBox) {
  // A large quad on the ground and a small one above it.
  std::vector<glm::vec4> vertices;
  for (const float size : {1.0f, 0.1f}) {
    for (int i = 0; i < 4; ++i)
      vertices.emplace_back(i & 1 ? size : -size, size < 1 ? 0.5f : 0, i & 2 ? size : -size, 0);
  }
  const RayBoxes boxes(vertices, {0, 1, 2, 2, 1, 3, 4, 5, 6, 6, 5, 7});
  EXPECT_TRUE(boxes.AreAllOutside([](const Box3f& box) { return box.max.y <= 0 || box.max.x <= 0.1f; }));
  EXPECT_FALSE(boxes.AreAllOutside([](const Box3f& box) { return box.max.y < 0.5f; }));
}

TEST(RayBoxesTest, NothingIsOutsideOfEverything) {
  EXPECT_TRUE(RayBoxes().AreAllOutside([](const Box3f&) { return false; }));
  EXPECT_TRUE(RayBoxes({}, {}).AreAllOutside([](const Box3f&) { return false; }));
}

}  // namespace
}  // namespace halfshade
