#include "server/validate.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/server/validate_request.h"
#include "tests/server/validate_rows.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

void AddSoftShadowMap(v1::RenderRequest& request, uint32_t size) {
  v1::Output* output = request.add_outputs();
  output->set_kind(v1::OUTPUT_KIND_SOFT_SHADOW_MAP);
  output->set_encoding(v1::ENCODING_EXR_FLOAT);
  output->set_light_map_size(size);
}

using Code = absl::StatusCode;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

std::vector<ValidateRow> FieldRows() {
  const Code ok = Code::kOk, bad = Code::kInvalidArgument;
  using Request = v1::RenderRequest;
  return {
      {"AsItIs", [](Request&) {}, ok, ""},
      {"SceneMissing", [](Request& r) { r.clear_scene(); }, bad, "scene: \"\"; must be scenes/"},
      {"SceneUpperCase", [](Request& r) { r.set_scene("scenes/" + std::string(64, 'A')); }, bad, "scene: "},
      {"WidthAtLimit",
       [](Request& r) {
         r.set_width(8192);
         r.set_height(16);
       },
       ok, ""},
      {"WidthOverLimit", [](Request& r) { r.set_width(8193); }, bad, "width: 8193; must be 1 to 8192"},
      {"HeightAtLimit",
       [](Request& r) {
         r.set_height(8192);
         r.set_width(16);
       },
       ok, ""},
      {"HeightOverLimit", [](Request& r) { r.set_height(100000); }, bad, "height: 100000; must be 1 to 8192"},
      {"SamplesOne", [](Request& r) { r.set_samples(1); }, ok, ""},
      {"SamplesTwo", [](Request& r) { r.set_samples(2); }, bad, "samples: 2; must be 1, 4 or 8"},
      {"SamplesFour", [](Request& r) { r.set_samples(4); }, ok, ""},
      {"SamplesFive", [](Request& r) { r.set_samples(5); }, bad, "samples: 5; must be 1, 4 or 8"},
      {"SamplesEight", [](Request& r) { r.set_samples(8); }, ok, ""},
      {"SamplesNine", [](Request& r) { r.set_samples(9); }, bad, "samples: 9; must be 1, 4 or 8"},
      {"SceneIndexZero", [](Request& r) { r.set_scene_index(0); }, ok, ""},
      {"SceneIndexOver", [](Request& r) { r.set_scene_index(1); }, bad, "scene_index: 1; the scene has 1"},
      {"EyeNan", [](Request& r) { LookAt(r).mutable_eye()->set_x(kNan); }, bad,
       "camera.look_at.eye.x: nan; must be finite"},
      {"EyeInf", [](Request& r) { LookAt(r).mutable_eye()->set_y(-kInf); }, bad,
       "camera.look_at.eye.y: -inf; must be finite"},
      {"EyeHuge", [](Request& r) { LookAt(r).mutable_eye()->set_y(1e16); }, bad,
       "camera.look_at.eye.y: 1e+16; must be -1e+15 to 1e+15"},
      {"EyeMissing", [](Request& r) { LookAt(r).clear_eye(); }, bad, "camera.look_at.eye: missing"},
      {"TargetMissing", [](Request& r) { LookAt(r).clear_target(); }, bad, "camera.look_at.target: missing"},
      {"TargetAtEye", [](Request& r) { LookAt(r).mutable_target()->set_z(5); }, bad,
       "camera.look_at.target: the same point as eye"},
      {"UpAlongView", [](Request& r) { LookAt(r).mutable_up()->set_z(1); }, bad, "camera.look_at.up: along the view"},
      {"UpZero", [](Request& r) { LookAt(r).mutable_up(); }, bad, "camera.look_at.up: along the view"},
      {"FovyZero", [](Request& r) { LookAt(r).set_fovy_deg(0); }, bad,
       "camera.look_at.fovy_deg: 0; must be at least 1e-15"},
      {"FovyUnderflows", [](Request& r) { LookAt(r).set_fovy_deg(1e-300); }, bad,
       "camera.look_at.fovy_deg: 1e-300; must be at least 1e-15 and under 180"},
      {"FovyWide", [](Request& r) { LookAt(r).set_fovy_deg(179.9); }, ok, ""},
      {"Fovy180", [](Request& r) { LookAt(r).set_fovy_deg(180); }, bad, "camera.look_at.fovy_deg: 180; must be"},
      {"OrthoOne", [](Request& r) { LookAt(r).set_ortho_height_m(1); }, ok, ""},
      {"OrthoSmallest", [](Request& r) { LookAt(r).set_ortho_height_m(1e-15); }, ok, ""},
      {"OrthoZero", [](Request& r) { LookAt(r).set_ortho_height_m(0); }, bad,
       "camera.look_at.ortho_height_m: 0; must be 1e-15 to 1e+15"},
      {"OrthoLargest", [](Request& r) { LookAt(r).set_ortho_height_m(1e15); }, ok, ""},
      {"OrthoNegative", [](Request& r) { LookAt(r).set_ortho_height_m(-1); }, bad,
       "camera.look_at.ortho_height_m: -1; must be 1e-15 to 1e+15"},
      {"NearZero", [](Request& r) { LookAt(r).set_near_m(0); }, bad,
       "camera.look_at.near_m: 0; must be 1e-15 to 1e+15"},
      {"NearUnderflows", [](Request& r) { LookAt(r).set_near_m(1e-300); }, bad,
       "camera.look_at.near_m: 1e-300; must be 1e-15 to 1e+15"},
      {"NearSmall", [](Request& r) { LookAt(r).set_near_m(1e-15); }, ok, ""},
      {"FarNan", [](Request& r) { LookAt(r).set_far_m(kNan); }, bad, "camera.look_at.far_m: nan; must be finite"},
      {"FarInfinite", [](Request& r) { LookAt(r).set_far_m(kInf); }, bad, "camera.look_at.far_m: inf; must be finite"},
      {"OrthoHuge", [](Request& r) { LookAt(r).set_ortho_height_m(1e16); }, bad,
       "camera.look_at.ortho_height_m: 1e+16; must be 1e-15 to 1e+15"},
      {"OrthoNan", [](Request& r) { LookAt(r).set_ortho_height_m(kNan); }, bad,
       "camera.look_at.ortho_height_m: nan; must be finite"},
      {"FovyNan", [](Request& r) { LookAt(r).set_fovy_deg(kNan); }, bad, "camera.look_at.fovy_deg: nan; must be"},
      {"UpTiny", [](Request& r) { LookAt(r).mutable_up()->set_y(1e-200); }, ok, ""},
      {"TargetNextToEye", [](Request& r) { LookAt(r).mutable_eye()->set_z(1e-160); }, bad,
       "camera.look_at.target: the same point as eye"},
      {"FarBelowNear",
       [](Request& r) {
         LookAt(r).set_near_m(2);
         LookAt(r).set_far_m(1);
       },
       bad, "camera.look_at.far_m: 1; must be over near_m (2)"},
      {"FarAlone", [](Request& r) { LookAt(r).set_far_m(100); }, ok, ""},
      {"CameraOfTheScene", [](Request& r) { r.mutable_camera()->set_index(0); }, ok, ""},
      {"CameraIndexOver", [](Request& r) { r.mutable_camera()->set_index(1); }, bad,
       "camera.index: 1; the scene has 1"},
      {"NoCamera", [](Request& r) { r.clear_camera(); }, ok, ""},
      {"NoLights", [](Request& r) { r.clear_lights(); }, ok, ""},
      {"LightsAtLimit",
       [](Request& r) {
         while (r.lights_size() < 64) *r.add_lights() = r.lights(0);
       },
       ok, ""},
      {"LightsOverLimit",
       [](Request& r) {
         while (r.lights_size() < 65) *r.add_lights() = r.lights(0);
       },
       bad, "lights: 65; this server takes at most 64"},
      {"CenterMissing", [](Request& r) { Light(r).clear_center(); }, bad, "lights[0].center: missing"},
      {"CenterNan", [](Request& r) { Light(r).mutable_center()->set_x(kNan); }, bad, "lights[0].center.x: nan"},
      {"EdgesSkewed", [](Request& r) { Light(r).mutable_edge_v()->set_x(0.01); }, bad, "lights[0].edge_v: cosine"},
      {"EdgesNearlyRight", [](Request& r) { Light(r).mutable_edge_v()->set_x(0.0009); }, ok, ""},
      {"DirectionWithTheNormal", [](Request& r) { Light(r).mutable_direction()->set_y(-1); }, ok, ""},
      {"DirectionAgainstTheNormal", [](Request& r) { Light(r).mutable_direction()->set_y(1); }, ok, ""},
      {"DirectionAside", [](Request& r) { Light(r).mutable_direction()->set_x(1); }, bad,
       "lights[0].direction: must be + or - normalize(cross(edge_u, edge_v))"},
      {"DirectionNotUnit", [](Request& r) { Light(r).mutable_direction()->set_y(-2); }, bad,
       "lights[0].direction: length 2; must be a unit vector"},
      {"LineWithoutDirection", [](Request& r) { Light(r).clear_edge_v(); }, bad,
       "lights[0].direction: missing; needed because edge_v has length 0"},
      {"PointWithoutDirection",
       [](Request& r) {
         Light(r).clear_edge_u();
         Light(r).clear_edge_v();
       },
       bad, "lights[0].direction: missing; needed because edge_u has length 0"},
      {"LineWithDirection",
       [](Request& r) {
         Light(r).clear_edge_v();
         Light(r).mutable_direction()->set_y(-1);
       },
       ok, ""},
      {"LineAlongDirection",
       [](Request& r) {
         Light(r).clear_edge_v();
         Light(r).mutable_direction()->set_x(1);
       },
       bad, "lights[0].direction: must be at right angles"},
      {"PointWithDirection",
       [](Request& r) {
         Light(r).clear_edge_u();
         Light(r).clear_edge_v();
         Light(r).mutable_direction()->set_y(-1);
       },
       ok, ""},
      {"RadianceNegative", [](Request& r) { Light(r).mutable_radiance()->set_g(-1); }, bad,
       "lights[0].radiance.g: -1; must not be negative"},
      {"RadianceNan", [](Request& r) { Light(r).mutable_radiance()->set_r(float(kNan)); }, bad,
       "lights[0].radiance.r: nan"},
      {"RadianceAtLimit", [](Request& r) { Light(r).mutable_radiance()->set_r(1e28f); }, ok, ""},
      {"RadianceOverLimit", [](Request& r) { Light(r).mutable_radiance()->set_r(2e28f); }, bad,
       "lights[0].radiance.r: "},
      {"RadianceZero", [](Request& r) { Light(r).mutable_radiance(); }, ok, ""},
      {"IntensityInf", [](Request& r) { Light(r).mutable_intensity()->set_b(float(kInf)); }, bad,
       "lights[0].intensity.b: inf"},
      {"TwoSided", [](Request& r) { Light(r).set_two_sided(true); }, ok, ""},
      {"EdgeNan", [](Request& r) { Light(r).mutable_edge_u()->set_x(kNan); }, bad, "lights[0].edge_u.x: nan"},
      {"EdgeInfinite", [](Request& r) { Light(r).mutable_edge_v()->set_z(kInf); }, bad, "lights[0].edge_v.z: inf"},
      {"TinyEdgesSkewed",
       [](Request& r) {
         Light(r).mutable_edge_u()->set_x(1e-160);
         Light(r).mutable_edge_v()->set_z(1e-160);
         Light(r).mutable_edge_v()->set_x(1e-160);
       },
       bad, "lights[0].edge_v: cosine"},
      {"DirectionNan", [](Request& r) { Light(r).mutable_direction()->set_y(kNan); }, bad,
       "lights[0].direction.y: nan"},
      {"SecondLightsFault",
       [](Request& r) {
         *r.add_lights() = r.lights(0);
         r.mutable_lights(1)->clear_center();
       },
       bad, "lights[1].center: missing"},
      {"GroundGood", [](Request& r) { r.mutable_ground()->set_size_m(10); }, ok, ""},
      {"GroundZero", [](Request& r) { r.mutable_ground()->set_size_m(0); }, bad,
       "ground.size_m: 0; must be 1e-15 to 1e+15"},
      {"GroundAtLimit", [](Request& r) { r.mutable_ground()->set_size_m(1e15); }, ok, ""},
      {"GroundOverLimit", [](Request& r) { r.mutable_ground()->set_size_m(1.1e15); }, bad,
       "ground.size_m: 1.1e+15; must be 1e-15 to 1e+15"},
      {"GroundNan",
       [](Request& r) {
         r.mutable_ground()->set_size_m(1);
         r.mutable_ground()->set_height_m(kNan);
       },
       bad, "ground.height_m: nan"},
      {"ShadowCatcher",
       [](Request& r) {
         r.mutable_ground()->set_size_m(1);
         r.mutable_ground()->set_shadow_catcher(true);
         r.add_outputs()->set_encoding(v1::ENCODING_RAW_F32);
       },
       ok, ""},
      {"ShadowCatcherOfNoSize", [](Request& r) { r.mutable_ground()->set_shadow_catcher(true); }, bad,
       "ground.size_m: 0; must be 1e-15 to 1e+15"},
      {"ShadowCatcherAsPng",
       [](Request& r) {
         r.mutable_ground()->set_size_m(1);
         r.mutable_ground()->set_shadow_catcher(true);
       },
       ok, ""},
      {"ShadowCatcherAsJpeg",
       [](Request& r) {
         r.mutable_ground()->set_size_m(1);
         r.mutable_ground()->set_shadow_catcher(true);
         r.add_outputs()->set_encoding(v1::ENCODING_JPEG);
       },
       bad, "outputs[0].encoding: JPEG holds no alpha"},
      {"Fog", [](Request& r) { r.mutable_fog(); }, ok, ""},
      {"FogMost",
       [](Request& r) {
         r.mutable_fog()->set_density_per_m(1e6);
         r.mutable_fog()->set_falloff_height_m(1e15);
         r.mutable_fog()->set_ground_m(-1e15);
         r.mutable_fog()->mutable_albedo()->set_g(1);
       },
       ok, ""},
      {"FogDensityBelow", [](Request& r) { r.mutable_fog()->set_density_per_m(-0.1); }, bad,
       "fog.density_per_m: -0.1; must be 0 to 1e+06"},
      {"FogDensityAbove", [](Request& r) { r.mutable_fog()->set_density_per_m(1.1e6); }, bad, "fog.density_per_m: 1"},
      {"FogDensityNan", [](Request& r) { r.mutable_fog()->set_density_per_m(NAN); }, bad, "fog.density_per_m: nan"},
      {"FogAlbedoAbove", [](Request& r) { r.mutable_fog()->mutable_albedo()->set_b(1.5f); }, bad,
       "fog.albedo.b: 1.5; must be 0 to 1"},
      {"FogAlbedoBelow", [](Request& r) { r.mutable_fog()->mutable_albedo()->set_r(-1); }, bad,
       "fog.albedo.r: -1; must be 0 to 1"},
      {"FogFalloffBelow", [](Request& r) { r.mutable_fog()->set_falloff_height_m(-1); }, bad,
       "fog.falloff_height_m: -1; must be 0 to 1e+15"},
      {"FogGroundInfinite", [](Request& r) { r.mutable_fog()->set_ground_m(INFINITY); }, bad, "fog.ground_m: inf"},
      {"FogOnACatcher",
       [](Request& r) {
         r.mutable_fog();
         r.mutable_ground()->set_size_m(1);
         r.mutable_ground()->set_shadow_catcher(true);
       },
       bad, "fog: with ground.shadow_catcher"},
      {"AnimationBefore", [](Request& r) { r.mutable_animation()->set_time_s(-1e-9); }, bad,
       "animation.time_s: -1e-09; must be 0 to 1e+06"},
      {"AnimationLate", [](Request& r) { r.mutable_animation()->set_time_s(1.1e6); }, bad,
       "animation.time_s: 1100000; must be 0"},
      {"AnimationNan", [](Request& r) { r.mutable_animation()->set_time_s(NAN); }, bad, "animation.time_s: nan"},
      {"BudgetEmpty", [](Request& r) { r.mutable_budget(); }, ok, ""},
      {"MaxErrorZero", [](Request& r) { r.mutable_budget()->set_max_error(0); }, bad,
       "budget.max_error: 0; must be over 0 and below 1"},
      {"MaxErrorOne", [](Request& r) { r.mutable_budget()->set_max_error(1); }, bad,
       "budget.max_error: 1; must be over 0 and below 1"},
      {"MaxErrorNaN", [](Request& r) { r.mutable_budget()->set_max_error(NAN); }, bad, "budget.max_error: "},
      {"MaxErrorLarge", [](Request& r) { r.mutable_budget()->set_max_error(0.999); }, ok, ""},
      {"MaxErrorSmall", [](Request& r) { r.mutable_budget()->set_max_error(1e-3); }, ok, ""},
      {"MaxLatencyZero", [](Request& r) { r.mutable_budget()->mutable_max_latency(); }, bad,
       "budget.max_latency: 0 s; must be .001 to 600"},
      {"MaxLatencyTooLong", [](Request& r) { r.mutable_budget()->mutable_max_latency()->set_seconds(601); }, bad,
       "budget.max_latency: 601 s; must be .001 to 600"},
      {"MaxLatencyLongest", [](Request& r) { r.mutable_budget()->mutable_max_latency()->set_seconds(600); }, ok, ""},
      {"CertifyLeast", [](Request& r) { Certify(r, 64, 16); }, ok, ""},
      {"CertifyMost", [](Request& r) { Certify(r, 1'000'000, 65536); }, ok, ""},
      {"CertifyEmpty", [](Request& r) { r.mutable_certify(); }, bad, "certify.pixels: 0; must be 64 to 1e+06"},
      {"CertifyFewPixels", [](Request& r) { Certify(r, 63, 16); }, bad, "certify.pixels: 63; must be 64 to 1e+06"},
      {"CertifyManyPixels", [](Request& r) { Certify(r, 1'000'001, 16); }, bad, "certify.pixels: 1000001; must be 64"},
      {"CertifyFewRays", [](Request& r) { Certify(r, 64, 15); }, bad, "certify.rays: 15; must be 16 to 65536"},
      {"CertifyManyRays", [](Request& r) { Certify(r, 64, 65537); }, bad, "certify.rays: 65537; must be 16 to 65536"},
      {"CertifyNormalsAlone",
       [](Request& r) {
         Certify(r, 64, 16);
         r.add_outputs()->set_kind(v1::OUTPUT_KIND_NORMAL);
       },
       bad, "certify: asked of outputs without visibility; needs FRAME or VISIBILITY"},
      {"ExposureHigh", [](Request& r) { r.mutable_shading()->set_exposure_ev(32); }, ok, ""},
      {"ExposureTooHigh", [](Request& r) { r.mutable_shading()->set_exposure_ev(33); }, bad,
       "shading.exposure_ev: 33; must be -32 to 32"},
      {"AmbientNegative", [](Request& r) { r.mutable_shading()->mutable_ambient()->set_r(-1); }, bad,
       "shading.ambient.r: -1"},
      {"BackgroundNan", [](Request& r) { r.mutable_shading()->mutable_background()->set_b(float(kNan)); }, bad,
       "shading.background.b: nan"},
      {"ExposureNan", [](Request& r) { r.mutable_shading()->set_exposure_ev(kNan); }, bad, "shading.exposure_ev: nan"},
      {"AmbientInfinite", [](Request& r) { r.mutable_shading()->mutable_ambient()->set_g(float(kInf)); }, bad,
       "shading.ambient.g: inf"},
      {"ToneMapNone", [](Request& r) { r.mutable_shading()->set_tone_map(v1::TONE_MAP_NONE); }, ok, ""},
      {"ToneMapAces", [](Request& r) { r.mutable_shading()->set_tone_map(v1::TONE_MAP_ACES); }, ok, ""},
      {"ToneMapNeutral", [](Request& r) { r.mutable_shading()->set_tone_map(v1::TONE_MAP_NEUTRAL); }, ok, ""},
      {"ToneMapNext", [](Request& r) { r.mutable_shading()->set_tone_map(v1::ToneMap(4)); }, bad,
       "shading.tone_map: 4; no such tone map"},
      {"ToneMapUnknown", [](Request& r) { r.mutable_shading()->set_tone_map(v1::ToneMap(77)); }, bad,
       "shading.tone_map: 77; no such"},
      {"PenumbraWidthOfPcss",
       [](Request& r) {
         r.mutable_method()->mutable_pcss();
         v1::Output* output = r.add_outputs();
         output->set_kind(v1::OUTPUT_KIND_PENUMBRA_WIDTH);
         output->set_encoding(v1::ENCODING_EXR_FLOAT);
       },
       ok, ""},
      {"PenumbraWidthInPng",
       [](Request& r) {
         r.mutable_method()->mutable_sssm();
         r.add_outputs()->set_kind(v1::OUTPUT_KIND_PENUMBRA_WIDTH);
       },
       bad, "outputs[0].encoding: PNG holds no metres"},
      {"SoftShadowMap", [](Request& r) { AddSoftShadowMap(r, 16); }, ok, ""},
      {"SoftShadowMapSizeLow", [](Request& r) { AddSoftShadowMap(r, 15); }, bad,
       "outputs[0].light_map_size: 15; must be 16 to 8192"},
      {"SoftShadowMapSizeHigh", [](Request& r) { AddSoftShadowMap(r, 8193); }, bad,
       "outputs[0].light_map_size: 8193; must be 16 to 8192"},
      {"SoftShadowMapPng",
       [](Request& r) {
         AddSoftShadowMap(r, 64);
         r.mutable_outputs(0)->set_encoding(v1::ENCODING_PNG);
       },
       bad, "outputs[0].encoding: PNG holds no metres"},
      {"SoftShadowMapTwoSizes",
       [](Request& r) {
         AddSoftShadowMap(r, 64);
         AddSoftShadowMap(r, 65);
       },
       bad, "outputs[1].light_map_size: 65; must be 64, as of the output before it"},
      {"SoftShadowMapTwoLights",
       [](Request& r) {
         AddSoftShadowMap(r, 64);
         while (r.lights_size() < 2) *r.add_lights() = Good().lights(0);
       },
       bad, "outputs[0].kind: SOFT_SHADOW_MAP of 2 lights; must be of one"},
      {"SoftShadowMapTwoSides",
       [](Request& r) {
         AddSoftShadowMap(r, 64);
         r.clear_lights();
         *r.add_lights() = Good().lights(0);
         r.mutable_lights(0)->set_two_sided(true);
       },
       bad, "outputs[0].kind: SOFT_SHADOW_MAP of a light with two sides; must be of one"},
      {"OutputUnknown",
       [](Request& r) {
         r.add_outputs();
         r.add_outputs()->set_kind(v1::OutputKind(99));
       },
       bad, "outputs[1].kind: 99; no such kind"},
      {"OutputExr", [](Request& r) { r.add_outputs()->set_encoding(v1::ENCODING_EXR_HALF); }, ok, ""},
      {"OutputVisibilityJpeg",
       [](Request& r) {
         r.add_outputs()->set_kind(v1::OUTPUT_KIND_VISIBILITY);
         r.mutable_outputs(0)->set_encoding(v1::ENCODING_JPEG);
       },
       bad, "outputs[0].encoding: JPEG holds colours"},
      {"LayerGood",
       [](Request& r) {
         for (const char* layer : {"a", "b"}) {
           v1::Output* o = r.add_outputs();
           o->set_encoding(v1::ENCODING_EXR_HALF);
           o->set_layer(layer);
         }
       },
       ok, ""},
      {"LayerWithoutExr", [](Request& r) { r.add_outputs()->set_layer("a"); }, bad,
       "outputs[0].layer: \"a\"; only EXR_HALF and EXR_FLOAT have layers"},
      {"LayerUnnameable",
       [](Request& r) {
         r.add_outputs()->set_encoding(v1::ENCODING_EXR_HALF);
         r.mutable_outputs(0)->set_layer("a\n");
       },
       bad, "outputs[0].layer: \"a\\n\"; must be 1 to 64"},
      {"LayerTwice",
       [](Request& r) {
         for (int i = 0; i < 2; ++i) {
           v1::Output* o = r.add_outputs();
           o->set_encoding(v1::ENCODING_EXR_HALF);
           o->set_layer("a");
         }
       },
       bad, "outputs[1].layer: \"a\"; outputs[0] has a channel a.R too"},
      {"EncodingUnknown", [](Request& r) { r.add_outputs()->set_encoding(v1::Encoding(42)); }, bad,
       "outputs[0].encoding: 42; no such"},
      {"VisibilityPngOfFour",
       [](Request& r) {
         while (r.lights_size() < 4) *r.add_lights() = r.lights(0);
         r.set_width(64);
         r.add_outputs()->set_kind(v1::OUTPUT_KIND_VISIBILITY);
       },
       ok, ""},
      {"VisibilityPngOfFive",
       [](Request& r) {
         while (r.lights_size() < 5) *r.add_lights() = r.lights(0);
         r.set_width(64);
         r.add_outputs()->set_kind(v1::OUTPUT_KIND_VISIBILITY);
       },
       bad, "outputs[0].encoding: PNG holds 4 channels"},
      {"ReplyFits",
       [](Request& r) {
         r.set_width(1024);
         r.set_height(1024);
         v1::Output* o = r.add_outputs();
         o->set_kind(v1::OUTPUT_KIND_VISIBILITY);
         o->set_encoding(v1::ENCODING_RAW_F32);
       },
       ok, ""},
      {"ReplyTooLarge",
       [](Request& r) {
         r.set_width(1025);
         r.set_height(1024);
         v1::Output* o = r.add_outputs();
         o->set_kind(v1::OUTPUT_KIND_VISIBILITY);
         o->set_encoding(v1::ENCODING_RAW_F32);
       },
       Code::kFailedPrecondition,
       "outputs: 4198400 bytes before compression; Render returns at most 4194304, use RenderStream"},
      {"CacheUnknown", [](Request& r) { r.set_cache(v1::CacheMode(9)); }, bad, "cache: 9; no such mode"},
      {"CacheRefresh", [](Request& r) { r.set_cache(v1::CACHE_MODE_REFRESH); }, ok, ""},
  };
}

std::vector<ValidateRow> Rows() {
  std::vector<ValidateRow> rows = FieldRows();
  const std::vector<ValidateRow> methods = MethodRows();
  rows.insert(rows.end(), methods.begin(), methods.end());
  return rows;
}

class ValidateRenderTest : public testing::TestWithParam<ValidateRow> {};
INSTANTIATE_TEST_SUITE_P(Fields, ValidateRenderTest, testing::ValuesIn(Rows()),
                         [](const auto& row) { return row.param.name; });

TEST_P(ValidateRenderTest, AnswersWithCodeFieldAndBound) {
  v1::RenderRequest request = Good();
  // Small, so that only the row's own size matters.
  request.set_width(320);
  request.set_height(180);
  GetParam().change(request);
  const auto result = ValidateRender(request, Scene(), Limits());
  EXPECT_EQ(result.status().code(), GetParam().code) << result.status();
  if (!result.ok()) {
    EXPECT_TRUE(std::string(result.status().message()).starts_with(GetParam().message)) << result.status();
  }
}

TEST(CheckRenderFieldsTest, NeedsNoSceneAndLeavesToItOnlyWhatTheSceneDecides) {
  v1::RenderRequest request = Good();
  request.set_scene_index(7);
  request.mutable_camera()->set_index(7);
  EXPECT_OK(CheckRenderFields(request, Limits()));
  for (const ValidateRow& row : Rows()) {
    if (row.name == "SceneIndexOver" || row.name == "CameraIndexOver") continue;
    v1::RenderRequest changed = Good();
    changed.set_width(320);
    changed.set_height(180);
    row.change(changed);
    EXPECT_EQ(CheckRenderFields(changed, Limits()).code(), row.code) << row.name;
  }
}

}  // namespace
}  // namespace halfshade
