// What ValidateRender makes of a good request; validate_test.cc has what it refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <set>
#include <string>

#include "server/report_to_proto.h"
#include "server/validate.h"
#include "tests/server/validate_request.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::HasSubstr;
using Code = absl::StatusCode;

TEST(ValidateRenderTest, SizeDefaultsTo1280By720) {
  v1::RenderRequest request = Good();
  const auto result = ValidateRender(request, Scene(), Limits());
  ASSERT_OK(result);
  EXPECT_EQ(result->request.width, 1280);
  EXPECT_EQ(result->request.height, 720);
}

TEST(ValidateRenderTest, AxesAreMadeExactAndRightHanded) {
  v1::RenderRequest request = Good();
  Light(request).mutable_edge_v()->set_x(0.0009);
  for (const double sign : {-1.0, 1.0}) {
    Light(request).mutable_direction()->set_y(sign);
    const auto result = ValidateRender(request, Scene(), Limits());
    ASSERT_OK(result);
    const AreaLight& light = result->request.lights[0];
    EXPECT_NEAR(glm::dot(light.axis_u_ws, light.axis_v_ws), 0, 1e-15);
    EXPECT_NEAR(glm::length(glm::cross(light.axis_u_ws, light.axis_v_ws) - light.normal_ws), 0, 1e-15);
    EXPECT_NEAR(light.normal_ws.y, sign, 1e-6);
  }
}

// Edges of 1e-300 to 1e15 m on lights near and far, in every order: squares of most of them under- or overflow.
TEST(ValidateRenderTest, WhatIsAcceptedIsFiniteAndItsAxesAreUnitWhateverTheScale) {
  const auto is_unit = [](const glm::dvec3& v) { return std::abs(glm::length(v) - 1) < 1e-12; };
  const auto is_float = [](double value) { return std::isfinite(float(value)); };
  const double scales[] = {1e-300, 1e-160, 1e-20, 1e-9, 1, 1e9, 1e15};
  for (const double u : scales) {
    for (const double v : scales) {
      for (const double away : {0.0, 1e-160, 3.0, 1e15}) {
        for (const float radiance : {-1.0f, 1.0f, 1e28f}) {
          v1::RenderRequest request = Good();
          Light(request).mutable_edge_u()->set_x(u);
          Light(request).mutable_edge_v()->set_z(v);
          Light(request).mutable_center()->set_y(away);
          if (radiance > 0) Light(request).mutable_radiance()->set_r(radiance);
          SCOPED_TRACE(request.lights(0).ShortDebugString());
          const auto result = ValidateRender(request, Scene(), Limits());
          ASSERT_OK(result);
          const AreaLight& light = result->request.lights[0];
          EXPECT_TRUE(is_unit(light.axis_u_ws) && is_unit(light.axis_v_ws) && is_unit(light.normal_ws));
          EXPECT_TRUE(is_float(light.radiance.r) && is_float(light.radiance.g));
          EXPECT_TRUE(is_float(light.intensity.r) && is_float(light.intensity.g));
          EXPECT_TRUE(is_float(std::exp2(32) * light.intensity.g)) << "the largest exposure";
        }
      }
    }
  }
}

TEST(ValidateRenderTest, AnEdgeBelowAMillionthOfTheDistanceMakesALineOrAPointOfTheSamePower) {
  v1::RenderRequest request = Good();  // 3 m from the target
  Light(request).mutable_edge_v()->set_z(2e-6);
  Light(request).mutable_radiance()->set_r(5e6);
  const auto line = ValidateRender(request, Scene(), Limits());
  ASSERT_OK(line);
  EXPECT_EQ(line->request.lights[0].width_m, 1);
  EXPECT_EQ(line->request.lights[0].height_m, 0);
  EXPECT_FLOAT_EQ(line->request.lights[0].intensity.r, 10);
  Light(request).mutable_edge_u()->set_x(1e-9);
  Light(request).mutable_intensity()->set_r(7);
  const auto point = ValidateRender(request, Scene(), Limits());
  ASSERT_OK(point);
  EXPECT_EQ(point->request.lights[0].width_m, 0);
  EXPECT_EQ(point->request.lights[0].intensity.r, 7) << "asked for, so not what radiance would give";
  Light(request).mutable_edge_u()->set_x(1);
  Light(request).mutable_edge_v()->set_z(4e-6);
  const auto rectangle = ValidateRender(request, Scene(), Limits());
  ASSERT_OK(rectangle);
  EXPECT_EQ(rectangle->request.lights[0].height_m, 4e-6);
  EXPECT_FLOAT_EQ(rectangle->request.lights[0].radiance.r, 5e6);
}

TEST(ValidateRenderTest, ACameraOnANodeScaledToNothingIsRefused) {
  FlatScene scene = Scene();
  scene.nodes[1].local = glm::dmat4(0);
  scene.nodes[1].local[3] = glm::dvec4(0, 0, 4, 1);
  v1::RenderRequest request = Good();
  request.mutable_camera()->set_index(0);
  EXPECT_THAT(ValidateRender(request, scene, Limits()),
              StatusIs(Code::kInvalidArgument, HasSubstr("camera.index: 0; the node's matrix")));
}

TEST(ValidateRenderTest, AFrameAsRawFloatsIsTooLargeForRenderAtTheDefaultSizeAndOutputsAddUp) {
  v1::RenderRequest request = Good();
  const auto code = [&] { return ValidateRender(request, Scene(), Limits()).status().code(); };
  request.add_outputs();  // 2.8 MB
  EXPECT_EQ(code(), Code::kOk);
  request.add_outputs()->set_kind(v1::OUTPUT_KIND_VISIBILITY);  // 1.8 MB
  EXPECT_EQ(code(), Code::kFailedPrecondition);
  request.clear_outputs();
  request.add_outputs()->set_encoding(v1::ENCODING_RAW_F32);  // 14.7 MB
  EXPECT_EQ(code(), Code::kFailedPrecondition);
}

TEST(ValidateRenderTest, ALightWithoutPowerSuitsItsDistanceWhateverTheScale) {
  v1::RenderRequest request = Good();
  const auto near = ValidateRender(request, Scene(), Limits());
  Light(request).mutable_center()->set_y(300);
  Light(request).mutable_edge_u()->set_x(100);
  Light(request).mutable_edge_v()->set_z(100);
  const auto far = ValidateRender(request, Scene(), Limits());
  ASSERT_OK(near);
  ASSERT_OK(far);
  EXPECT_FLOAT_EQ(near->request.lights[0].radiance.r, far->request.lights[0].radiance.r);
}

TEST(ValidateRenderTest, ABareSceneGetsCameraLightAndGround) {
  v1::RenderRequest request;
  request.set_scene(kScene);
  const auto result = ValidateRender(request, Scene(), Limits());
  ASSERT_OK(result);
  EXPECT_EQ(result->request.lights.size(), 1u);
  EXPECT_TRUE(result->request.ground.has_value());
  EXPECT_EQ(std::get<ShaftOptions>(result->request.method).rows, 0);
  EXPECT_TRUE(result->request.is_auto);
  EXPECT_THAT(result->request.method_reason, HasSubstr("auto, shaft: predicted error"));
}

TEST(ValidateRenderTest, ABudgetThatNothingMeetsNamesTheBestPossible) {
  v1::RenderRequest request = Good();
  request.clear_method();
  request.mutable_budget()->set_max_error(1e-6);
  EXPECT_THAT(ValidateRender(request, Scene(), Limits()),
              StatusIs(Code::kFailedPrecondition, HasSubstr("budget.max_error: 1e-06; the least possible is ")));
  request.mutable_budget()->set_max_error(0.01);
  EXPECT_OK(ValidateRender(request, Scene(), Limits()));
  request.mutable_budget()->mutable_max_latency()->set_nanos(1'000'000);
  EXPECT_THAT(ValidateRender(request, Scene(), Limits()),
              StatusIs(Code::kFailedPrecondition, HasSubstr("budget.max_latency: 1.0 ms; the least possible is ")));
}

TEST(ValidateRenderTest, ALatencyRefusesAMethodThatIsPredictedToBeLate) {
  v1::RenderRequest request = Good();
  request.mutable_method()->mutable_multi_map()->set_k(64);
  request.mutable_budget()->mutable_max_latency()->set_seconds(10);
  EXPECT_OK(ValidateRender(request, Scene(), Limits()));
  EXPECT_THAT(ValidateRender(request, Scene(), Limits(), {.slowness = 60}),
              StatusIs(Code::kFailedPrecondition,
                       HasSubstr("budget.max_latency: 10000 ms; the method with these options is predicted to take ")));
  request.mutable_budget()->clear_max_latency();
  EXPECT_OK(ValidateRender(request, Scene(), Limits(), {.slowness = 60}));
}

TEST(ValidateRenderTest, ABudgetOfAMethodThatDoesNotTellItsErrorIsMeasured) {
  v1::RenderRequest request = Good();
  request.mutable_method()->mutable_pcss();
  EXPECT_FALSE(ValidateRender(request, Scene(), Limits())->request.certify.has_value());
  request.mutable_budget()->set_max_error(0.01);
  EXPECT_TRUE(ValidateRender(request, Scene(), Limits())->request.certify.has_value());
  request.mutable_method()->mutable_ray();
  EXPECT_FALSE(ValidateRender(request, Scene(), Limits())->request.certify.has_value());
}

TEST(ValidateRenderTest, EveryMethodIsThere) {
  const auto* fields = v1::Method::descriptor();
  for (int i = 0; i < fields->field_count(); ++i) {
    const auto* field = fields->field(i);
    v1::RenderRequest request = Good();
    v1::Method* method = request.mutable_method();
    method->GetReflection()->MutableMessage(method, field);
    const absl::Status status = CheckRenderFields(request, Limits());
    EXPECT_OK(status) << field->name();
  }
}

TEST(ValidateRenderTest, EveryKindIsTakenInEveryEncodingThatItHas) {
  for (int kind = 0; kind < v1::OutputKind_ARRAYSIZE; ++kind) {
    for (int encoding = 0; encoding < v1::Encoding_ARRAYSIZE; ++encoding) {
      v1::RenderRequest request = Good();
      request.set_width(64);
      v1::Output* output = request.add_outputs();
      output->set_kind(v1::OutputKind(kind));
      output->set_encoding(v1::Encoding(encoding));
      const absl::Status status = CheckRenderFields(request, Limits());
      SCOPED_TRACE(output->ShortDebugString());
      if (!FormatOf(*FromProto(v1::OutputKind(kind)), *FromProto(v1::Encoding(encoding)), 1, false).ok()) {
        EXPECT_THAT(status, StatusIs(Code::kInvalidArgument, HasSubstr("outputs[0].encoding: ")));
      } else {
        EXPECT_OK(status);
      }
    }
  }
}

TEST(ValidateRenderTest, TheReplysBytesAreThoseOfItsSamples) {
  v1::RenderRequest request = Good();
  request.set_width(10);
  request.set_height(10);
  request.add_outputs();
  request.add_outputs()->set_encoding(v1::ENCODING_EXR_HALF);
  EXPECT_EQ(ValidateRender(request, Scene(), Limits())->reply_bytes, 300u + 800u);
  request.clear_outputs();
  EXPECT_EQ(ValidateRender(request, Scene(), Limits())->reply_bytes, 300u) << "none is a FRAME as PNG";
}

TEST(ValidateRenderTest, WhatIsAskedOfTheCameraSideArrives) {
  v1::RenderRequest request = Good();
  request.set_width(32);
  request.set_samples(8);
  request.mutable_ground()->set_size_m(3);
  request.mutable_ground()->set_shadow_catcher(true);
  const std::pair<v1::OutputKind, OutputKind> kinds[] = {
      {v1::OUTPUT_KIND_FRAME, OutputKind::kFrame},       {v1::OUTPUT_KIND_VISIBILITY, OutputKind::kVisibility},
      {v1::OUTPUT_KIND_DEPTH, OutputKind::kDepth},       {v1::OUTPUT_KIND_NORMAL, OutputKind::kNormal},
      {v1::OUTPUT_KIND_ALBEDO, OutputKind::kAlbedo},     {v1::OUTPUT_KIND_OBJECT_ID, OutputKind::kObjectId},
      {v1::OUTPUT_KIND_POSITION, OutputKind::kPosition},
  };
  for (const auto& kind : kinds) {
    request.add_outputs()->set_kind(kind.first);
    request.mutable_outputs()->rbegin()->set_encoding(v1::ENCODING_RAW_F32);
  }
  const std::pair<v1::ToneMap, ToneMap> curves[] = {{v1::TONE_MAP_UNSPECIFIED, ToneMap::kNone},
                                                    {v1::TONE_MAP_NONE, ToneMap::kNone},
                                                    {v1::TONE_MAP_ACES, ToneMap::kAces},
                                                    {v1::TONE_MAP_NEUTRAL, ToneMap::kNeutral}};
  for (const auto& curve : curves) {
    request.mutable_shading()->set_tone_map(curve.first);
    const auto result = ValidateRender(request, Scene(), Limits());
    ASSERT_OK(result);
    EXPECT_EQ(result->request.shading.tone_map, curve.second);
    EXPECT_EQ(result->request.samples, 8);
    EXPECT_TRUE(result->request.ground->is_shadow_catcher);
    ASSERT_EQ(result->request.outputs.size(), std::size(kinds));
    for (size_t i = 0; i < std::size(kinds); ++i) EXPECT_EQ(result->request.outputs[i], kinds[i].second);
  }
  request.clear_samples();
  EXPECT_EQ(ValidateRender(request, Scene(), Limits())->request.samples, 1);
}

TEST(ValidateRenderTest, AnOrthographicViewBeginsAtItsEyeUnlessToldOtherwise) {
  v1::RenderRequest request = Good();
  LookAt(request).set_ortho_height_m(3);
  const auto whole = ValidateRender(request, Scene(), Limits());
  ASSERT_OK(whole);
  EXPECT_TRUE(whole->request.camera.is_orthographic);
  EXPECT_EQ(whole->request.camera.ortho_height_m, 3);
  EXPECT_EQ(whole->request.camera.near_m, 0);
  LookAt(request).set_near_m(0.5);
  LookAt(request).set_far_m(7);
  const auto cut = ValidateRender(request, Scene(), Limits());
  ASSERT_OK(cut);
  EXPECT_EQ(cut->request.camera.near_m, 0.5);
  EXPECT_EQ(cut->request.camera.far_m, 7);
}

// The cameras of a file obey the limits of a request's own, each on both sides.
TEST(ValidateRenderTest, ASceneCameraBeyondTheLimitsIsRefusedByItsIndexAndProperty) {
  struct CameraRow {
    std::function<void(SceneCamera&, glm::dmat4&)> change;
    std::string message;  // "": accepted
  };
  const auto ortho = [](SceneCamera& c) {
    c.is_orthographic = true;
    c.ortho_height_m = 2;
    c.near_m = 0;
    c.far_m = 10;
  };
  const CameraRow rows[] = {
      {[&](SceneCamera& c, glm::dmat4&) { ortho(c); }, ""},
      {[&](SceneCamera& c, glm::dmat4&) { ortho(c), c.ortho_height_m = 2e15; }, ""},
      {[&](SceneCamera& c, glm::dmat4&) { ortho(c), c.ortho_height_m = 2.2e15; },
       "camera.index: 0; ymag: 1.1e+15; must be 1e-15 to 1e+15"},
      {[&](SceneCamera& c, glm::dmat4&) { ortho(c), c.ortho_height_m = 2e-16; }, "camera.index: 0; ymag: 1e-16; must"},
      {[&](SceneCamera& c, glm::dmat4&) { ortho(c), c.far_m = 1e15; }, ""},
      {[&](SceneCamera& c, glm::dmat4&) { ortho(c), c.far_m = 1e16; }, "camera.index: 0; zfar: 1e+16; must be"},
      {[](SceneCamera& c, glm::dmat4&) { c.near_m = 1e-15; }, ""},
      {[](SceneCamera& c, glm::dmat4&) { c.near_m = 1e-20; }, "camera.index: 0; znear: 1e-20; must be"},
      {[](SceneCamera& c, glm::dmat4&) { c.near_m = 0; }, "camera.index: 0; znear: 0; must be"},
      {[](SceneCamera& c, glm::dmat4&) { c.far_m = 1e90; }, "camera.index: 0; zfar: 1e+90; must be"},
      {[](SceneCamera& c, glm::dmat4&) { c.fovy_rad = 1e-16; }, ""},
      {[](SceneCamera& c, glm::dmat4&) { c.fovy_rad = 1e-18; }, "camera.index: 0; yfov: 1e-18; must be"},
      {[](SceneCamera&, glm::dmat4& m) { m[3].y = -1e15; }, ""},
      {[](SceneCamera&, glm::dmat4& m) { m[3].y = -1e16; }, "camera.index: 0; eye.y: -1e+16; must be -1e+15 to 1e+15"},
  };
  v1::RenderRequest request = Good();
  request.mutable_camera()->set_index(0);
  for (const CameraRow& row : rows) {
    FlatScene scene = Scene();
    row.change(scene.cameras[0], scene.nodes[1].local);
    const absl::Status status = ValidateRender(request, scene, Limits()).status();
    if (row.message.empty()) {
      EXPECT_OK(status);
    } else {
      EXPECT_THAT(status, StatusIs(Code::kInvalidArgument, HasSubstr(row.message)));
    }
  }
}

TEST(ValidateRenderTest, ASceneCameraThatNoNodeHoldsIsRefused) {
  FlatScene scene = Scene();
  scene.nodes[1].camera = -1;
  v1::RenderRequest request = Good();
  request.mutable_camera()->set_index(0);
  EXPECT_THAT(ValidateRender(request, scene, Limits()),
              StatusIs(Code::kInvalidArgument, HasSubstr("camera.index: 0; no node of the scene holds this camera")));
}

TEST(ValidateRenderTest, ScatterIsAsPrintedUnlessToldOtherwise) {
  v1::RenderRequest request = Good();
  v1::SsmOptions* asked = request.mutable_method()->mutable_ssm();
  const auto ssm = [&] { return std::get<SsmOptions>(ValidateRender(request, Scene(), Limits())->request.method); };
  EXPECT_FALSE(ssm().projects_map);
  EXPECT_EQ(ssm().sub_lights, 0);
  EXPECT_TRUE(ssm().measures_coverage);
  asked->set_accumulation(v1::SSM_ACCUMULATION_SCATTER);
  EXPECT_EQ(ssm().accumulation, SsmAccumulation::kScatter);
  EXPECT_TRUE(ssm().projects_map);
  EXPECT_EQ(ssm().sub_lights, 1);
  EXPECT_FALSE(ssm().measures_coverage);
  EXPECT_EQ(ssm().blend, SsmBlend::kFp32);
  asked->set_blend(v1::SSM_BLEND_FP16_BATCHED);
  asked->set_coverage(true);
  asked->set_sub_lights(3);
  EXPECT_EQ(ssm().blend, SsmBlend::kFp16Batched);
  EXPECT_TRUE(ssm().measures_coverage);
  EXPECT_EQ(ssm().sub_lights, 3);
  asked->set_blend(v1::SSM_BLEND_FP16);
  EXPECT_EQ(ssm().blend, SsmBlend::kFp16);
}

TEST(ValidateRenderTest, EpsOfPdsmIsByDefaultWhatItsStepsOrRampsBear) {
  v1::RenderRequest request = Good();
  v1::PdsmOptions& pdsm = *request.mutable_method()->mutable_pdsm();
  const auto eps = [&] {
    return std::get<PdsmOptions>(ValidateRender(request, Scene(), Limits())->request.method).eps;
  };
  EXPECT_EQ(eps(), 0.01f);
  pdsm.set_k(16);
  EXPECT_EQ(eps(), 1.0f / 32);
  pdsm.set_soft_events(true);
  EXPECT_EQ(eps(), 0.002f);
  pdsm.set_eps(0.02f);
  EXPECT_EQ(eps(), 0.02f);
}

TEST(ContentKeyTest, DependsOnWhatIsRenderedAndOnNothingElse) {
  v1::RenderRequest request = Good();
  const auto key = [&] { return ContentKey(kScene, *ValidateRender(request, Scene(), Limits()), "1", "gl"); };
  const std::string first = key();
  EXPECT_EQ(first, key());
  request.set_expected_frames(9);
  request.set_width(1280);  // the default said aloud
  EXPECT_EQ(first, key());
  request.set_seed(1);
  EXPECT_NE(first, key());
  request.set_seed(0);
  request.mutable_method()->mutable_multi_map()->set_k(65);
  EXPECT_NE(first, key());
  v1::SsmOptions* ssm = request.mutable_method()->mutable_ssm();
  std::set<std::string> of_ssm = {key()};
  ssm->set_resolve(v1::SSM_RESOLVE_MAP);
  of_ssm.insert(key());
  ssm->set_accumulation(v1::SSM_ACCUMULATION_SCATTER);
  of_ssm.insert(key());
  ssm->set_blend(v1::SSM_BLEND_FP16);
  of_ssm.insert(key());
  EXPECT_EQ(of_ssm.size(), 4u);
  request.clear_method();
  EXPECT_EQ(first, key());
  request.set_samples(4);
  EXPECT_NE(first, key());
  request.set_samples(1);
  EXPECT_EQ(first, key());
  request.mutable_fog()->set_density_per_m(0.1);
  const std::string with_fog = key();
  EXPECT_NE(first, with_fog);
  request.mutable_fog()->set_density_per_m(0.2);
  EXPECT_NE(with_fog, key());
  request.clear_fog();
  EXPECT_EQ(first, key());
  request.mutable_method()->mutable_pdsm()->set_layout(v1::PDSM_LAYOUT_INDEXED);
  const std::string indexed = key();
  request.mutable_method()->mutable_pdsm()->set_surface_only(true);
  EXPECT_NE(indexed, key());
  request.mutable_method()->mutable_pdsm()->set_surface_only(false);
  request.mutable_method()->mutable_pdsm()->set_soft_events(true);
  EXPECT_NE(indexed, key());
  request.clear_method();
  request.mutable_shading()->set_tone_map(v1::TONE_MAP_NEUTRAL);
  EXPECT_NE(first, key());
}

}  // namespace
}  // namespace halfshade
