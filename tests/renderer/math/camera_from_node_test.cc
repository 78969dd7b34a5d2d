#include <gtest/gtest.h>

#include "renderer/math/camera.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

TEST(CameraFromNodeTest, ANodeScaledToNothingIsRefused) {
  for (const int lost : {1, 2}) {
    glm::dmat4 flat(1);
    flat[lost] = glm::dvec4(0);
    EXPECT_THAT(CameraFromNode(flat, 2), StatusIs(absl::StatusCode::kInvalidArgument, testing::HasSubstr("no axes")));
  }
}

TEST(CameraFromNodeTest, IgnoresScaleAndKeepsARightHandedFrame) {
  // A quarter turn about y takes -z to -x; scales, one of them negative, change nothing.
  const glm::dmat4 turned(glm::dvec4(0, 0, -3, 0), glm::dvec4(0, 0.5, 0, 0), glm::dvec4(7, 0, 0, 0),
                          glm::dvec4(1, 2, 3, 1));
  glm::dmat4 mirrored = turned;
  mirrored[0] = -mirrored[0];
  for (const glm::dmat4& node : {turned, mirrored}) {
    const auto camera = CameraFromNode(node, 2);
    ASSERT_OK(camera);
    EXPECT_EQ(camera->forward_ws, glm::dvec3(-1, 0, 0));
    EXPECT_EQ(camera->up_ws, glm::dvec3(0, 1, 0));
    EXPECT_EQ(camera->right_ws, glm::cross(camera->forward_ws, camera->up_ws));
    EXPECT_EQ(camera->target_ws, glm::dvec3(-1, 2, 3));
  }
}

}  // namespace
}  // namespace halfshade
