// The ground as a shadow catcher: FRAME over a picture darkens it as the shadow would.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/renderer/shade/render_image.h"

namespace halfshade {
namespace {

FlatScene Scene() { return MakeFlatScene({MakeBox({0, 0.5, 0}, {1, 1, 1})}); }

RenderRequest Request() {
  RenderRequest request;
  request.camera = LookFrom({4, 4, 5}, {0, 0, 0});
  request.width = 96;
  request.height = 72;
  request.ground = Ground{0, 8, true};
  request.lights = {LightAbove(3, 0.8, {-1, 0.5})};
  request.method = MultiMapOptions{16, 256};
  return request;
}

Image Frame(const RenderRequest& request) { return RenderImage(Scene(), request, OutputKind::kFrame); }

Image Without(RenderRequest request, bool occluder) {
  request.ground->is_shadow_catcher = false;
  FlatScene scene = Scene();
  if (!occluder) scene.scenes[0].roots.clear();
  return RenderImage(scene, request, OutputKind::kFrame);
}

// P over: what a compositor does.
float Over(const Image& frame, int x, int y, int c, float picture) {
  return frame.at(x, y, c) + (1 - frame.at(x, y, 3)) * picture;
}

struct Counts {
  int objects = 0, shadow = 0, lit = 0, background = 0;
};

// Compares the catcher over the unshadowed ground with the frame that has a ground.
Counts CompareWithTheGround(const RenderRequest& request) {
  const Image caught = Frame(request), shadowed = Without(request, true), bare = Without(request, false);
  const Image ids = RenderImage(Scene(), request, OutputKind::kObjectId);
  Counts counts;
  for (int y = 0; y < request.height; ++y) {
    for (int x = 0; x < request.width; ++x) {
      const float alpha = caught.at(x, y, 3);
      EXPECT_TRUE(alpha >= 0 && alpha <= 1);
      if (ids.at(x, y, 0) == 0) {
        ++counts.background;
        for (int c = 0; c < 4; ++c) EXPECT_EQ(caught.at(x, y, c), 0);
      } else if (ids.at(x, y, 0) == 1) {
        ++counts.objects;
        for (int c = 0; c < 4; ++c) EXPECT_EQ(caught.at(x, y, c), shadowed.at(x, y, c));
      } else {
        ++(alpha > 0 ? counts.shadow : counts.lit);
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(Over(caught, x, y, c, bare.at(x, y, c)), shadowed.at(x, y, c), 1e-5) << x << "," << y;
        }
      }
    }
  }
  return counts;
}

TEST(ShadowCatcherTest, OverTheUnshadowedGroundItIsTheShadowedGround) {
  const Counts counts = CompareWithTheGround(Request());
  EXPECT_GT(counts.objects, 200);
  EXPECT_GT(counts.shadow, 200);
  EXPECT_GT(counts.lit, 500);
  EXPECT_GT(counts.background, 200);
}

TEST(ShadowCatcherTest, LightsOfOtherColoursLeaveTheirTint) {
  RenderRequest request = Request();
  request.lights.push_back(LightAbove(3, 0.3, {1.5, 0}));
  request.lights[0].radiance = {1, 0.2f, 0.1f};
  request.lights[1].radiance = {0, 3, 9};
  request.shading.ambient = glm::vec3(0);
  EXPECT_GT(CompareWithTheGround(request).shadow, 250);
  const Image caught = Frame(request);
  double tint = 0;
  for (int y = 0; y < request.height; ++y) {
    for (int x = 0; x < request.width; ++x) {
      if (caught.at(x, y, 3) < 1) tint = std::max(tint, double(caught.at(x, y, 0)));
    }
  }
  EXPECT_GT(tint, 1e-3) << "red light alone is left where the second light is hidden";
}

TEST(ShadowCatcherTest, UnderWhiteLightItsColourIsBlack) {
  const RenderRequest request = Request();
  const Image caught = Frame(request);
  const Image ids = RenderImage(Scene(), request, OutputKind::kObjectId);
  double darkest = 0;
  for (int y = 0; y < request.height; ++y) {
    for (int x = 0; x < request.width; ++x) {
      if (ids.at(x, y, 0) != 2) continue;
      for (int c = 0; c < 3; ++c) EXPECT_LE(caught.at(x, y, c), 1e-7);
      darkest = std::max(darkest, double(caught.at(x, y, 3)));
    }
  }
  EXPECT_GT(darkest, 0.25);
  EXPECT_LT(darkest, 1) << "ambient light is never hidden";
}

// Where the horizon takes part of a light, no occluder does: that is no shadow.
TEST(ShadowCatcherTest, ALightPartlyBelowTheGroundCastsNoShadowOfItsOwn) {
  RenderRequest request = Request();
  AreaLight& light = request.lights[0];
  light.center_ws = {-6, 0, 0};
  light.axis_u_ws = {0, 1, 0};
  light.axis_v_ws = {0, 0, 1};
  light.normal_ws = {1, 0, 0};
  light.width_m = light.height_m = 4;
  request.camera = LookDown(5, 2);
  request.camera.eye_ws.x = request.camera.target_ws.x = -2.5;  // between the light and the box
  request.ground->size_m = 20;
  request.shading.ambient = glm::vec3(0);
  const Image caught = Frame(request);
  ASSERT_GT(caught.size(), 0u);
  // Half of the light is below; of 16 samples one or two may fall on the wrong side of the horizon.
  EXPECT_LE(*std::max_element(caught.data(), caught.data() + caught.size()), 2.0 / 16 / 0.5);
}

TEST(ShadowCatcherTest, WithoutLightThereIsNothingToHide) {
  RenderRequest request = Request();
  request.lights[0].radiance = glm::vec3(0);
  request.shading.ambient = glm::vec3(0);
  const Image caught = Frame(request);
  const Image ids = RenderImage(Scene(), request, OutputKind::kObjectId);
  ASSERT_TRUE(caught.size() && ids.size());
  for (size_t i = 0; i < ids.size(); ++i) EXPECT_EQ(caught.data()[4 * i + 3], ids.data()[i] == 1 ? 1 : 0);
}

TEST(ShadowCatcherTest, SamplesAverageWhatIsPremultiplied) {
  RenderRequest request = Request();
  request.samples = 4;
  request.shading.ambient = glm::vec3(0.5f);
  const Image caught = Frame(request);
  ASSERT_GT(caught.size(), 0u);
  int partial = 0;
  for (int y = 0; y < request.height; ++y) {
    for (int x = 0; x < request.width; ++x) {
      const float alpha = caught.at(x, y, 3);
      // A box under light of at most 1 everywhere: no colour without coverage.
      for (int c = 0; c < 3; ++c) EXPECT_LE(caught.at(x, y, c), alpha + 1e-6f);
      partial += alpha == 0.25f || alpha == 0.5f || alpha == 0.75f;
    }
  }
  EXPECT_GT(partial, 20) << "the box's edges against the background and the lit ground";
}

}  // namespace
}  // namespace halfshade
