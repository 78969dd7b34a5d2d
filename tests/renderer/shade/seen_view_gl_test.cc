// What a camera sees is drawn once, whatever lights move before it.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

class SeenViewTest : public testing::Test {
 protected:
  SeenViewTest() {
    const MadeScene made = MakeScene("S3", {.light_share = 0.2});
    scene_ = MakeFlatScene(made.meshes);
    request_ = RequestFor(made);
    request_.width = 96;
    request_.height = 54;
    request_.outputs = {OutputKind::kFrame, OutputKind::kVisibility};
  }
  ~SeenViewTest() override { TestRenderer().ForgetScene("seen"); }

  RenderResult Render(CacheMode cache = CacheMode::kUse) {
    request_.cache = cache;
    auto result = TestRenderer().Render("seen", scene_, request_, [] { return absl::OkStatus(); });
    EXPECT_OK(result);
    return result.ok() ? *std::move(result) : RenderResult();
  }
  static bool IsSeenAgain(const RenderResult& result) {
    return std::any_of(result.report.passes.begin(), result.report.passes.end(),
                       [](const PassReport& pass) { return pass.name == "gbuffer" && pass.is_skipped; });
  }
  // As if nothing had been kept.
  void ExpectRight(const RenderResult& result) {
    const RenderResult fresh = Render(CacheMode::kRefresh);
    EXPECT_FALSE(IsSeenAgain(fresh));
    for (size_t i = 0; i < fresh.images.size(); ++i) {
      const Image &a = fresh.images[i].image, &b = result.images[i].image;
      ASSERT_EQ(a.size(), b.size());
      EXPECT_TRUE(std::equal(a.data(), a.data() + a.size(), b.data()));
    }
  }
  FlatScene scene_;
  RenderRequest request_;
};

TEST_F(SeenViewTest, ALightOrAMethodThatChangesDrawsItNoMoreToTheSameBytes) {
  EXPECT_FALSE(IsSeenAgain(Render()));
  request_.lights[0].center_ws.x += 0.1;
  for (const MethodOptions& method : {MethodOptions(ShaftOptions{}), MethodOptions(PcssOptions{}),
                                      MethodOptions(RayOptions{.rays = 16}), MethodOptions(ShaftOptions{.rows = 8})}) {
    request_.method = method;
    const RenderResult result = Render();
    EXPECT_TRUE(IsSeenAgain(result));
    ExpectRight(result);
  }
}

TEST_F(SeenViewTest, WhateverItShowsDrawsItAgain) {
  Render();
  const RenderRequest first = request_;
  const auto changes = {
      +[](RenderRequest& r) { r.camera.eye_ws.x += 1e-3; },
      +[](RenderRequest& r) { r.width = 95; },
      +[](RenderRequest& r) { r.outputs = {OutputKind::kVisibility}; },
      +[](RenderRequest& r) {
        r.ground = Ground{-0.5, 3};
      },
      +[](RenderRequest& r) { r.node_overrides.emplace_back().is_visible = false; },
      +[](RenderRequest& r) { r.node_overrides.emplace_back().receives = false; },
      +[](RenderRequest& r) { r.node_overrides.emplace_back().local = glm::scale(glm::dmat4(1), glm::dvec3(0.5)); },
  };
  for (const auto& change : changes) {
    request_ = first;
    change(request_);
    const RenderResult result = Render();
    EXPECT_FALSE(IsSeenAgain(result));
    ExpectRight(result);
  }
}

TEST_F(SeenViewTest, AForgottenScenesViewIsGone) {
  Render();
  TestRenderer().ForgetScene("seen");
  EXPECT_FALSE(IsSeenAgain(Render()));
}

}  // namespace
}  // namespace halfshade
