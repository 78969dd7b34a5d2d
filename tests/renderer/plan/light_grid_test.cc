#include "renderer/plan/light_grid.h"

#include <gtest/gtest.h>

#include "renderer/math/camera.h"
#include "renderer/math/light_frame.h"
#include "tests/support/flat_scene_builder.h"

namespace halfshade {
namespace {

// A light of 1 x 1 at height 3, a box of 1 x 1 x 1 around y = 1, a ground of 20 x 20.
class LightGridTest : public testing::Test {
 protected:
  LightGridTest() : scene_(MakeFlatScene({MakeBox({0, 1, 0}, {1, 1, 1})})), pose_(*BuildPose(scene_, 0)) {
    light_.center_ws = {0, 3, 0};
    light_.axis_u_ws = {1, 0, 0};
    light_.axis_v_ws = {0, 0, 1};
    light_.normal_ws = {0, -1, 0};
    light_.width_m = light_.height_m = 1;
    request_.ground = Ground{0, 20, false};
  }
  LightGrid Plan() const { return PlanLightGrid(scene_, pose_, GridReceivers(pose_, request_), request_, light_); }

  FlatScene scene_;
  Pose pose_;
  RenderRequest request_;
  AreaLight light_;
};

TEST_F(LightGridTest, TheGroundReceivesAndWhatThrowsTheShadowDoesNot) {
  EXPECT_TRUE(GridReceivers(pose_, request_).instances.empty());
  request_.ground.reset();
  EXPECT_EQ(GridReceivers(pose_, request_).instances.size(), 1u) << "nothing else is there";
  pose_.instances[0].receives = false;
  EXPECT_TRUE(GridReceivers(pose_, request_).instances.empty());
}

TEST_F(LightGridTest, TheWindowHoldsTheWholeShadowAndLittleElse) {
  // The box's top, 1.5 before the light, is seen under 1/1.5 from the far end of the light; a 64th more on each side.
  const double reach = 2.0 / 3 * (1 + 1.0 / 32);
  const LightGrid grid = Plan();
  for (const double low : {grid.window.x, grid.window.y}) EXPECT_NEAR(low, -reach, 1e-6);
  for (const double high : {grid.window.z, grid.window.w}) EXPECT_NEAR(high, reach, 1e-6);
  EXPECT_EQ(glm::dvec3(grid.light_from_world * glm::dvec4(0.5, 1, -0.25, 1)), glm::dvec3(0.5, -0.25, 2));
}

TEST_F(LightGridTest, ASmallGroundBoundsIt) {
  request_.ground->size_m = 0.6;
  const LightGrid grid = Plan();
  EXPECT_NEAR(grid.window.z, 0.1, 0.01);
}

TEST_F(LightGridTest, ItsCameraSeesTexelsWhereTheFormulaSays) {
  light_.center_ws = {0.7, 3, -0.2};  // no window around the axis
  const LightGrid grid = Plan();
  EXPECT_NEAR(grid.window.z - grid.window.x, grid.window.w - grid.window.y, 1e-12);
  EXPECT_GT(std::abs(grid.window.x + grid.window.z), 0.1);
  const Camera camera = CameraOf(grid, light_, request_);
  const glm::dmat3 ray_from_ndc = RayFromNdc(camera, 1);
  const LightFrame frame = MakeLightFrame(light_);
  constexpr int kSize = 8;
  for (int j = 0; j < kSize; ++j) {
    for (int i = 0; i < kSize; ++i) {
      const glm::dvec3 ray_ws = ray_from_ndc * glm::dvec3(2 * (i + 0.5) / kSize - 1, 1 - 2 * (j + 0.5) / kSize, 1);
      const glm::dvec3 ray = frame.light_from_world_rotation * ray_ws;
      EXPECT_NEAR(ray.x / ray.z, glm::mix(grid.window.x, grid.window.z, (i + 0.5) / kSize), 1e-12);
      EXPECT_NEAR(ray.y / ray.z, glm::mix(grid.window.y, grid.window.w, (j + 0.5) / kSize), 1e-12);
    }
  }
}

}  // namespace
}  // namespace halfshade
