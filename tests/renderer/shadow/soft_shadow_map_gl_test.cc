// The light's own output: visibility of what its centre sees of the receivers, by every method.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/support/closed_forms.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

class SoftShadowMapTest : public testing::TestWithParam<TestMethod> {
 protected:
  // A plate of edge .8, 1 m before a light of edge .4 that is 2 m above the ground.
  SoftShadowMapTest() : scene_(MakeFlatScene({MakePlate({0.1, 1, 0}, 0.8, 0.8)})) {
    request_.camera = LookFrom({3, 3, 3}, {0, 0, 0});
    request_.ground = Ground{2e-4, 2, false};  // at y = 0, 1e-4 of its size lower than told
    request_.lights = {LightAbove(2, 0.4)};
    request_.method = GetParam().options;
    request_.outputs = {OutputKind::kSoftShadowMap};
    request_.light_map_size = 96;
  }

  RenderedImage Draw() {
    auto result = TestRenderer().Render("test", scene_, request_, [] { return absl::OkStatus(); });
    TestRenderer().ForgetScene("test");
    EXPECT_OK(result);
    if (!result.ok()) return {};
    report_ = result->report;
    for (RenderedImage& image : result->images) {
      if (image.kind == OutputKind::kSoftShadowMap) return std::move(image);
    }
    return {};
  }

  FlatScene scene_;
  RenderRequest request_;
  RenderReport report_;
};
INSTANTIATE_TEST_SUITE_P(Methods, SoftShadowMapTest, testing::ValuesIn(TestMethods()), TestMethodName);

TEST_P(SoftShadowMapTest, ATexelHoldsTheVisibilityOfThePointThatTheWindowSays) {
  const RenderedImage map = Draw();
  ASSERT_TRUE(map.grid.has_value());
  ASSERT_EQ(map.image.width(), 96);
  ASSERT_EQ(map.image.channels(), 2);
  const glm::dvec4 window = map.grid->window;
  double error = 0;
  int shadowed = 0, empty = 0, edge = 0;
  for (int j = 0; j < 96; ++j) {
    for (int i = 0; i < 96; ++i) {
      const double z = map.image.at(i, j, 1);
      const double u = glm::mix(window.x, window.z, (i + 0.5) / 96);
      const double v = glm::mix(window.y, window.w, (j + 0.5) / 96);
      if (z == 0) {
        ++empty;
        EXPECT_EQ(map.image.at(i, j, 0), 1);
        EXPECT_GT(std::max(std::abs(u), std::abs(v)), 0.5 - 1e-3) << "the ground is there";
        continue;
      }
      EXPECT_NEAR(z, 2, 1e-5);
      edge += i == 0 || j == 0 || i == 95 || j == 95;
      // Light frame: x along world x, y along world z.
      const double truth = VisibilityBehindPlate({0.2, 0.2}, {0.1, 0, 1}, {0.4, 0.4}, {u * z, v * z, z});
      if (truth > 1 - 1.0 / 512) continue;
      ++shadowed;
      error += std::abs(map.image.at(i, j, 0) - truth);
    }
  }
  std::printf("%s: mae_shadowed %.5f of %d texels, %d without a receiver\n", GetParam().name.c_str(), error / shadowed,
              shadowed, empty);
  EXPECT_GT(shadowed, 1000);
  EXPECT_GT(edge + empty, 0);
  // HARD takes a ramp for a step, wrong by 1/4 on average over the penumbra, which is (2^2 - 1.2^2) / 2^2 of the
  // shadow.
  EXPECT_LE(error / shadowed, GetParam().name == "hard" ? 0.25 * 0.64 : 0.02);
}

TEST_P(SoftShadowMapTest, TheCameraHasNoPartInIt) {
  const RenderedImage map = Draw();
  EXPECT_TRUE(std::none_of(report_.passes.begin(), report_.passes.end(),
                           [](const PassReport& pass) { return pass.name == "gbuffer" && !pass.is_skipped; }));
  request_.camera = LookFrom({0, 3, 30}, {0, 100, 60});
  request_.camera.target_ws = {0, 0, 0};
  request_.outputs = {OutputKind::kFrame, OutputKind::kSoftShadowMap, OutputKind::kVisibility};
  request_.width = 32;
  request_.height = 16;
  const RenderedImage again = Draw();
  ASSERT_EQ(map.image.size(), again.image.size());
  EXPECT_TRUE(std::equal(map.image.data(), map.image.data() + map.image.size(), again.image.data()));
}

TEST_P(SoftShadowMapTest, WithoutAnOccluderAllIsLit) {
  scene_ = MakeFlatScene({MakePlate({0.1, 3, 0}, 0.8, 0.8)});  // behind the light
  const RenderedImage map = Draw();
  ASSERT_GT(map.image.size(), 0u);
  for (int j = 0; j < 96; ++j) {
    for (int i = 0; i < 96; ++i) ASSERT_EQ(map.image.at(i, j, 0), 1);
  }
}

}  // namespace
}  // namespace halfshade
