#include "renderer/plan/frame_plan.h"

#include <gtest/gtest.h>

#include <random>

#include "renderer/math/light_frame.h"
#include "renderer/plan/framing.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/render_fixture.h"

namespace halfshade {
namespace {

RenderRequest Request() {
  RenderRequest request;
  request.camera = LookFrom({3, 3, 3}, {0, 0, 0});
  request.width = request.height = 64;
  request.lights = {LightAbove(3, 1)};
  request.outputs = {OutputKind::kFrame};
  return request;
}

FramePlan Plan(const FlatScene& scene, const RenderRequest& request) {
  return PlanFrame(scene, *BuildPose(scene, 0), request);
}

TEST(PlanFrameTest, VisibilityAloneNeedsNoShadingAndNoTextures) {
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0, 0}, {1, 1, 1})});
  RenderRequest request = Request();
  EXPECT_TRUE(Plan(scene, request).needs_materials);
  request.outputs = {OutputKind::kVisibility};
  EXPECT_FALSE(Plan(scene, request).needs_shading);
  EXPECT_FALSE(Plan(scene, request).needs_materials);
}

TEST(PlanFrameTest, ViewsDrawWhatTheirOutputsNeedAndNoMore) {
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0, 0}, {1, 1, 1})});
  RenderRequest request = Request();
  struct Row {
    std::vector<OutputKind> outputs;
    int samples;
    size_t views;
    bool data, data_materials, data_ids, frame_ids;
  };
  using Kind = OutputKind;
  for (const bool has_catcher : {false, true}) {
    request.ground = Ground{0, 5, has_catcher};
    const Row rows[] = {
        {{Kind::kFrame}, 1, 1, false, true, has_catcher, has_catcher},
        {{Kind::kFrame, Kind::kObjectId}, 1, 1, true, true, true, true},
        {{Kind::kFrame}, 8, 8, false, true, has_catcher, has_catcher},
        {{Kind::kFrame, Kind::kDepth}, 4, 5, true, false, false, has_catcher},
        {{Kind::kNormal, Kind::kFrame}, 4, 5, true, true, false, has_catcher},
        {{Kind::kObjectId, Kind::kFrame}, 4, 5, true, false, true, has_catcher},
        {{Kind::kVisibility}, 8, 1, true, false, false, false},
        {{Kind::kAlbedo}, 4, 1, true, true, false, false},
    };
    for (const Row& row : rows) {
      request.outputs = row.outputs;
      request.samples = row.samples;
      const FramePlan plan = Plan(scene, request);
      ASSERT_EQ(plan.views.size(), row.views);
      EXPECT_EQ(plan.views.front().shows_data, row.data);
      EXPECT_EQ(plan.views.front().needs_materials, row.data_materials);
      EXPECT_EQ(plan.views.front().needs_object_ids, row.data_ids);
      glm::dvec2 mean(0);
      int frames = 0;
      for (const ViewPlan& view : plan.views) {
        frames += view.shows_frame;
        mean += view.offset_pixels;
        EXPECT_TRUE(view.needs_materials || !view.shows_frame);
        if (view.shows_frame) {
          EXPECT_EQ(view.needs_object_ids, row.frame_ids);
        }
        EXPECT_TRUE(!view.shows_data || view.offset_pixels == glm::dvec2(0)) << "data is sampled at pixel centres";
      }
      EXPECT_EQ(frames, plan.needs_shading ? row.samples : 0);
      EXPECT_EQ(mean, glm::dvec2(0)) << "the picture does not move";
    }
  }
}

TEST(PlanFrameTest, WithoutAnOutputThatShowsLightLightsAreSkipped) {
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0, 0}, {1, 1, 1})});
  RenderRequest request = Request();
  request.outputs = {OutputKind::kDepth, OutputKind::kNormal, OutputKind::kObjectId};
  EXPECT_EQ(Plan(scene, request).lights[0].outcome, LightOutcome::kSkipped);
  EXPECT_EQ(Plan(scene, request).lights[0].reason, "lights[0]: no output shows light");
  request.outputs.push_back(OutputKind::kVisibility);
  EXPECT_EQ(Plan(scene, request).lights[0].outcome, LightOutcome::kCompute);
}

TEST(PlanFrameTest, AnOrthographicCameraEndsCloseBehindWhatIsVisible) {
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0, 0}, {1, 1, 1})});
  RenderRequest request = Request();
  EXPECT_EQ(Plan(scene, request).camera_far_m, 0) << "perspective: infinite";
  request.camera = LookDown(10, 4);
  EXPECT_EQ(Plan(scene, request).camera_far_m, 100) << "as asked";
  request.camera.far_m = 0;
  EXPECT_GT(Plan(scene, request).camera_far_m, 10.5);
  EXPECT_LT(Plan(scene, request).camera_far_m, 10.5 * (1 + 1e-5));
  request.camera.eye_ws.y = -10;
  EXPECT_FALSE(Plan(scene, request).draws_gbuffer) << "everything is behind the camera";
}

// A sample may see what no pixel's centre does.
TEST(PlanFrameTest, WhatOnlySamplesBesideTheCentresSeeIsDrawn) {
  const FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 1, 1)});
  RenderRequest request = Request();
  request.camera = LookDown(10, 4);
  request.width = request.height = 4;       // a pixel is 1 m
  request.camera.eye_ws.x = 0.5 + 2 + 0.2;  // the view begins .2 m beside the plate
  EXPECT_FALSE(Plan(scene, request).draws_gbuffer);
  request.samples = 8;
  EXPECT_TRUE(Plan(scene, request).draws_gbuffer);
}

TEST(PlanFrameTest, VisibilityNeedsTexturesWhereAMaskDecides) {
  FlatScene scene = MakeFlatScene({MakeBox({0, 0, 0}, {1, 1, 1})});
  scene.textures.resize(1);
  scene.materials[0].base_color_texture.texture = 0;
  RenderRequest request = Request();
  request.outputs = {OutputKind::kVisibility};
  EXPECT_FALSE(Plan(scene, request).needs_textures);
  scene.materials[0].alpha_mode = AlphaMode::kMask;
  EXPECT_TRUE(Plan(scene, request).needs_textures);
  EXPECT_FALSE(Plan(scene, request).needs_shading);
  scene.scenes[0].roots.clear();
  EXPECT_FALSE(Plan(scene, request).needs_textures) << "another glTF scene's mask";
}

TEST(PlanFrameTest, ALightWithoutPowerIsSkippedUnlessItsVisibilityIsAsked) {
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0, 0}, {1, 1, 1})});
  RenderRequest request = Request();
  EXPECT_EQ(Plan(scene, request).lights[0].outcome, LightOutcome::kCompute);
  request.lights[0].radiance = glm::vec3(0);
  EXPECT_EQ(Plan(scene, request).lights[0].outcome, LightOutcome::kSkipped);
  EXPECT_EQ(Plan(scene, request).lights[0].reason, "lights[0]: emits nothing, and visibility is not asked");
  request.outputs.push_back(OutputKind::kVisibility);
  EXPECT_EQ(Plan(scene, request).lights[0].outcome, LightOutcome::kCompute);
}

TEST(PlanFrameTest, ALightThatFacesAwayNeedsNoMaps) {
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0, 0}, {1, 1, 1})});
  RenderRequest request = Request();
  request.lights[0].center_ws.y = -2;
  EXPECT_EQ(Plan(scene, request).lights[0].outcome, LightOutcome::kNoMapNeeded);
  EXPECT_EQ(Plan(scene, request).lights[0].reason, "lights[0]: faces away from every receiver");
}

TEST(PlanFrameTest, AnOccluderBesideTheHullNeedsNoMaps) {
  FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 1, 1), MakeBox({5, 1, 0}, {1, 1, 1})});
  Pose pose = *BuildPose(scene, 0);
  pose.instances[0].casts = false;
  pose.instances[1].receives = false;
  RenderRequest request = Request();
  EXPECT_EQ(PlanFrame(scene, pose, request).lights[0].outcome, LightOutcome::kNoMapNeeded);
  pose.instances[1].world_from_mesh[3].x -= 5;
  EXPECT_EQ(PlanFrame(scene, pose, request).lights[0].outcome, LightOutcome::kCompute);
}

TEST(PlanFrameTest, OnlyWhatIsDrawnAndReceivesIsAReceiver) {
  // A plate that receives below a plate that hides the light.
  FlatScene scene = MakeFlatScene({MakePlate({0, 0, 0}, 1, 1), MakePlate({0, 1, 0}, 1, 1)});
  Pose pose = *BuildPose(scene, 0);
  const auto outcome = [&] { return PlanFrame(scene, pose, Request()).lights[0].outcome; };
  EXPECT_EQ(outcome(), LightOutcome::kCompute);
  pose.instances[1].is_visible = false;
  EXPECT_EQ(outcome(), LightOutcome::kCompute) << "it still casts";
  pose.instances[0].receives = false;
  EXPECT_EQ(outcome(), LightOutcome::kNoMapNeeded);
  EXPECT_EQ(PlanFrame(scene, pose, Request()).lights[0].reason, "lights[0]: no receiver is in view");
  EXPECT_TRUE(PlanFrame(scene, pose, Request()).draws_gbuffer) << "it is still seen";
  pose.instances[0].receives = true;
  pose.instances[0].is_visible = false;
  EXPECT_EQ(outcome(), LightOutcome::kNoMapNeeded);
  EXPECT_FALSE(PlanFrame(scene, pose, Request()).draws_gbuffer);
}

TEST(PlanFrameTest, ATwoSidedLightIsTwoOneSidedOnesBackToBack) {
  RenderRequest request = Request();
  request.lights = {LightAbove(0, 1), LightAbove(5, 1)};
  request.lights[0].is_two_sided = true;
  const FlatScene scene =
      MakeFlatScene({MakePlate({0, 2, 0}, 1, 1), MakePlate({0, 1, 0}, 1, 1), MakePlate({0, -1, 0}, 1, 1)});
  Pose pose = *BuildPose(scene, 0);
  pose.instances[2].casts = false;
  const FramePlan plan = PlanFrame(scene, pose, request);
  ASSERT_EQ(plan.lights.size(), 3u);
  for (const LightPlan& side : plan.lights) EXPECT_FALSE(side.light.is_two_sided);
  EXPECT_EQ(plan.lights[0].light.normal_ws, glm::dvec3(0, -1, 0));
  EXPECT_EQ(plan.lights[1].light.normal_ws, glm::dvec3(0, 1, 0));
  EXPECT_EQ(glm::cross(plan.lights[1].light.axis_u_ws, plan.lights[1].light.axis_v_ws), glm::dvec3(0, 1, 0));
  EXPECT_TRUE(!plan.lights[0].is_back && plan.lights[1].is_back && !plan.lights[2].is_back);
  EXPECT_EQ(plan.lights[1].index, 0u);
  EXPECT_EQ(plan.lights[2].index, 1u);
  EXPECT_EQ(plan.lights[0].outcome, LightOutcome::kNoMapNeeded) << "nothing between it and the plate below";
  EXPECT_EQ(plan.lights[1].outcome, LightOutcome::kCompute) << "one plate hides it from the other";
}

TEST(PlanFrameTest, TheSideOfATwoSidedLightThatLightsNothingIsLeftOut) {
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0, 0}, {1, 1, 1})});
  RenderRequest request = Request();
  request.lights[0].is_two_sided = true;
  for (const double height : {3.0, -3.0}) {
    request.lights[0].center_ws.y = height;
    const FramePlan plan = Plan(scene, request);
    const LightPlan& front = plan.lights[0];
    const LightPlan& back = plan.lights[1];
    EXPECT_EQ((height > 0 ? front : back).outcome, LightOutcome::kCompute);
    EXPECT_EQ((height > 0 ? back : front).outcome, LightOutcome::kSkipped);
  }
  EXPECT_EQ(Plan(scene, request).lights[0].reason, "lights[0]: faces away from every receiver");
  // A receiver in the light's own plane: somebody must say that it is dark.
  request.lights[0].center_ws.y = 0;
  const FramePlan plan = Plan(MakeFlatScene({MakePlate({0, 0, 0}, 1, 1)}), request);
  EXPECT_EQ(plan.lights[0].outcome, LightOutcome::kNoMapNeeded);
  EXPECT_EQ(plan.lights[1].outcome, LightOutcome::kSkipped);
}

TEST(PlanFrameTest, NothingInViewDrawsNothing) {
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0, 0}, {1, 1, 1})});
  RenderRequest request = Request();
  EXPECT_TRUE(Plan(scene, request).draws_gbuffer);
  request.camera = LookFrom({3, 3, 3}, {6, 6, 6});
  EXPECT_FALSE(Plan(scene, request).draws_gbuffer);
  EXPECT_EQ(Plan(scene, request).gbuffer_reason, "nothing is in view");
}

// Conservative: wherever a segment from the light to a receiver meets an occluder's box, the skip must not fire.
TEST(PlanFrameTest, FogIsShadowedWhereNoReceiverIs) {
  const FlatScene scene = MakeFlatScene({MakeBox({0, 0, 0}, {1, 1, 1})});
  RenderRequest request = Request();
  request.camera = LookFrom({5, 0, 0}, {10, 0, 0});  // away from the box
  EXPECT_EQ(Plan(scene, request).lights[0].outcome, LightOutcome::kNoMapNeeded);
  request.fog = Fog{};
  EXPECT_EQ(Plan(scene, request).lights[0].outcome, LightOutcome::kCompute) << "the air is seen";
  request.outputs = {OutputKind::kVisibility};
  EXPECT_EQ(Plan(scene, request).lights[0].outcome, LightOutcome::kNoMapNeeded) << "fog is of FRAME alone";
  request.outputs = {OutputKind::kFrame};
  request.node_overrides = {{.node = 0, .local = std::nullopt, .casts = false}};
  EXPECT_EQ(PlanFrame(scene, *BuildPose(scene, 0, request.node_overrides), request).lights[0].outcome,
            LightOutcome::kNoMapNeeded);
}

TEST(IsOneFlatOccluderTest, IsSaidOfOnePlateAlone) {
  const GlbMesh plate = MakePlate({0, 1, 0}, 1, 1), box = MakeBox({0, 0, 0}, {1, 1, 1});
  const auto is_flat = [](const FlatScene& scene, const std::vector<NodeOverride>& overrides = {}) {
    return IsOneFlatOccluder(scene, *BuildPose(scene, 0, overrides));
  };
  EXPECT_TRUE(is_flat(MakeFlatScene({plate})));
  EXPECT_FALSE(is_flat(MakeFlatScene({box})));
  EXPECT_FALSE(is_flat(MakeFlatScene({plate, plate})));
  EXPECT_TRUE(is_flat(MakeFlatScene({plate, box}), {{.node = 1, .local = std::nullopt, .casts = false}}));
  EXPECT_FALSE(is_flat(MakeFlatScene({plate}), {{.node = 0, .local = std::nullopt, .casts = false}}));
}

TEST(HasNoOccluderTest, NeverSkipsAnOccluderThatASegmentMeets) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto point = [&](double scale) { return glm::dvec3(unit(random), unit(random), unit(random)) * scale; };
  int skips = 0, met = 0;
  for (int round = 0; round < 3000; ++round) {
    AreaLight light = LightAbove(2, 0.2 + std::abs(unit(random)));
    Box3d receiver, occluder;
    for (int i = 0; i < 2; ++i) receiver.Add(point(2));
    const glm::dvec3 at = point(3);
    for (int i = 0; i < 2; ++i) occluder.Add(at + point(1.5));
    const bool skips_it = HasNoOccluder(light, {occluder}, {receiver});
    skips += skips_it;
    const LightFrame frame = MakeLightFrame(light);
    bool meets = false;
    for (int i = 0; i < 300 && !meets; ++i) {
      const glm::dvec3 to =
          glm::mix(receiver.min, receiver.max, glm::dvec3(unit(random), unit(random), unit(random)) * 0.5 + 0.5);
      if (PointToLight(frame, to).z <= 0) continue;
      const glm::dvec3 from = light.center_ws + light.axis_u_ws * (unit(random) * light.width_m / 2) +
                              light.axis_v_ws * (unit(random) * light.height_m / 2);
      const glm::dvec3 p = glm::mix(from, to, std::abs(unit(random)));
      meets = glm::all(glm::greaterThanEqual(p, occluder.min)) && glm::all(glm::lessThanEqual(p, occluder.max));
    }
    met += meets;
    EXPECT_FALSE(skips_it && meets) << round;
  }
  EXPECT_GT(skips, 100);
  EXPECT_GT(met, 100);
}

TEST(SeesNoneTest, NeverSkipsABoxWithAPointInView) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Camera camera = LookFrom({0, 0, 5}, {0, 0, 0});
  int skips = 0;
  for (int round = 0; round < 2000; ++round) {
    Box3d box;
    for (int i = 0; i < 2; ++i) box.Add(glm::dvec3(unit(random), unit(random), unit(random)) * 8.0);
    const bool sees_none = SeesNone(camera, 1, {box});
    skips += sees_none;
    for (int i = 0; i < 50; ++i) {
      const glm::dvec3 p = glm::mix(box.min, box.max, glm::dvec3(unit(random), unit(random), unit(random)) * 0.5 + 0.5);
      const double depth = 5 - p.z;
      const bool in_view = depth > camera.near_m && std::abs(p.x) < depth * camera.tan_half_fovy &&
                           std::abs(p.y) < depth * camera.tan_half_fovy;
      EXPECT_FALSE(sees_none && in_view);
    }
  }
  EXPECT_GT(skips, 50);
}

TEST(GroundQuadTest, LiesUnderTheTargetALittleLowerThanTold) {
  RenderRequest request = Request();
  request.camera.target_ws = {7, 1, -2};
  request.ground = Ground{0.5, 10, false};
  const auto quad = GroundQuad(request);
  EXPECT_EQ((quad[0] + quad[2]) * 0.5, glm::dvec3(7, 0.5 - 1e-3, -2));
  EXPECT_EQ(glm::length(quad[1] - quad[0]), 10);
}

TEST(FramingTest, TheWholeBoxIsInViewAtEveryAspectAndScale) {
  for (const double aspect : {0.4, 1.0, 1.78, 4.0}) {
    for (const double scale : {1e-6, 1.0, 1e6}) {
      Box3d box;
      box.Add(glm::dvec3(-1, 0, -3) * scale);
      box.Add(glm::dvec3(2, 5, 1) * scale);
      const Camera camera = FrameScene(box, aspect);
      for (int i = 0; i < 8; ++i) {
        const glm::dvec3 corner(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                                i & 4 ? box.max.z : box.min.z);
        const glm::dvec3 v = corner - camera.eye_ws;
        const double depth = glm::dot(v, camera.forward_ws);
        EXPECT_GT(depth, camera.near_m);
        EXPECT_LT(std::abs(glm::dot(v, camera.right_ws)), depth * camera.tan_half_fovy * aspect);
        EXPECT_LT(std::abs(glm::dot(v, camera.up_ws)), depth * camera.tan_half_fovy);
      }
    }
  }
}

TEST(FramingTest, NothingAndAPointGiveSomethingFinite) {
  Box3d point;
  point.Add(glm::dvec3(1e6, 0, 0));
  for (const Box3d& box : {Box3d(), point}) {
    const Camera camera = FrameScene(box, 1.5);
    const AreaLight light = SuitingLight(box);
    EXPECT_TRUE(std::isfinite(glm::length(camera.eye_ws)) && camera.near_m > 0);
    EXPECT_TRUE(light.width_m > 0 && std::isfinite(glm::length(light.center_ws)));
    EXPECT_GT(SuitingGround(box).size_m, 0);
  }
}

}  // namespace
}  // namespace halfshade
