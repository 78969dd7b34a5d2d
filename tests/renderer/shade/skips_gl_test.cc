// Pictures with what the plan leaves out and without: the same bytes.
#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/plan/choose_method.h"
#include "renderer/plan/frame_plan.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

RenderResult Render(const FlatScene& scene, const RenderRequest& request) {
  auto result = TestRenderer().Render("skips", scene, request, [] { return absl::OkStatus(); });
  TestRenderer().ForgetScene("skips");
  EXPECT_OK(result);
  return result.ok() ? *std::move(result) : RenderResult();
}

const PassReport* FindPass(const RenderReport& report, const std::string& name) {
  const auto found = std::find_if(report.passes.begin(), report.passes.end(),
                                  [&](const PassReport& pass) { return pass.name == name; });
  return found == report.passes.end() ? nullptr : &*found;
}

void ExpectSame(const Image& a, const Image& b) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_GT(a.size(), 0u);
  EXPECT_TRUE(std::equal(a.data(), a.data() + a.size(), b.data()));
}

TEST(SkipsTest, TrianglesOutOfViewAreNotDrawn) {
  const MadeScene made = MakeScene("S6", {.triangles = 20000});
  const FlatScene scene = MakeFlatScene(made.meshes);
  FlatScene whole = scene;  // its clusters reach into every view
  for (Cluster& cluster : whole.clusters) cluster.bounds = {glm::vec3(-1e6f), glm::vec3(1e6f)};
  RenderRequest request = RequestFor(made);
  request.width = 96;
  request.height = 54;
  request.outputs = {OutputKind::kFrame, OutputKind::kVisibility, OutputKind::kDepth, OutputKind::kNormal,
                     OutputKind::kObjectId};
  const Camera from_afar = request.camera;
  uint64_t left_out = 0, drawn = 0;
  for (const double tan_half_fovy : {0.4, 0.1, 0.03}) {
    for (const bool is_orthographic : {false, true}) {
      for (const int samples : {1, 4}) {
        request.camera = from_afar;
        request.camera.tan_half_fovy = tan_half_fovy;
        request.camera.is_orthographic = is_orthographic;
        request.camera.ortho_height_m = 3 * tan_half_fovy;
        request.samples = samples;
        const RenderResult with = Render(scene, request), without = Render(whole, request);
        for (size_t i = 0; i < request.outputs.size(); ++i) ExpectSame(with.images[i].image, without.images[i].image);
        const std::string name = samples == 1 ? "gbuffer" : "view[0]/gbuffer";
        left_out += FindPass(without.report, name)->count - FindPass(with.report, name)->count;
        drawn += FindPass(without.report, name)->count;
        EXPECT_EQ(FindPass(without.report, name)->reason, "");
      }
    }
  }
  EXPECT_GT(left_out, drawn / 40) << "the narrowest views leave most of the sheet out";
}

TEST(SkipsTest, ALightThatNothingHidesFromWhatIsSeenNeedsNoMap) {
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0.5, 0}, {1, 1, 1})});
  RenderRequest request;
  request.width = request.height = 48;
  request.lights = {LightAbove(4, 0.5)};
  request.ground = Ground{0, 40, false};
  // The ground beside the box, and its shadow too.
  for (const auto& [target_x, is_hidden] : {std::pair{8.0, false}, std::pair{1.5, true}}) {
    request.camera = LookFrom({target_x, 3, 3}, {target_x, 0, 0});
    request.camera.target_ws = {0, 0, 0};  // keeps the ground where it is
    for (const MethodOptions& method : {MethodOptions(ShaftOptions{}), MethodOptions(MultiMapOptions{4, 64})}) {
      request.method = method;
      request.outputs = {OutputKind::kVisibility};
      const RenderResult with = Render(scene, request);
      request.outputs = {OutputKind::kVisibility, OutputKind::kSoftShadowMap};  // of all receivers: nothing is skipped
      const RenderResult without = Render(scene, request);
      ExpectSame(with.images[0].image, without.images[0].image);
      EXPECT_EQ(FindPass(with.report, "light[0]/light_data") != nullptr, is_hidden);
      EXPECT_NE(FindPass(without.report, "light[0]/light_data"), nullptr);
    }
  }
}

TEST(SkipsTest, OneFlatOccluderNeedsNoSecondLayer) {
  RenderRequest request;
  request.width = 64;
  request.height = 48;
  request.camera = LookFrom({2, 3, 4}, {0, 0, 0});
  request.lights = {LightAbove(4, 1)};
  request.ground = Ground{0, 8, false};
  request.outputs = {OutputKind::kVisibility};
  for (const bool is_flat : {true, false}) {
    const FlatScene scene = MakeFlatScene({is_flat ? MakePlate({0, 1, 0}, 1, 1) : MakeSphere({0, 1, 0}, 0.7, 16)});
    const Pose pose = *BuildPose(scene, 0);
    request.method = SsmOptions{.occluder_map_size = 64, .passes = 2, .sub_lights = 2};
    const Image without = Render(scene, request).images[0].image;
    RenderRequest settled = request;
    ASSERT_OK(SettleMethod(scene, pose, ReceiverCount(request), &settled));
    EXPECT_EQ(std::get<SsmOptions>(settled.method).passes, is_flat ? 1 : 2);
    ExpectSame(Render(scene, settled).images[0].image, without);
  }
}

}  // namespace
}  // namespace halfshade
