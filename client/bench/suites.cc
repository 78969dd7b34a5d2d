#include "client/bench/suites.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "client/exit_code.h"
#include "client/field_text.h"
#include "client/view_file.h"
#include "renderer/status.h"
#include "server/digest.h"
#include "server/scene_name.h"
#include "tests/support/scene_makers.h"

namespace halfshade::bench {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kWidth = 640, kHeight = 360;

struct SettingText {
  const char* method;
  std::vector<std::string> options;  // "key=value"
  int filter_radius = 0;
};

absl::StatusOr<std::vector<Setting>> MakeSettings(const std::vector<SettingText>& texts,
                                                  const std::vector<std::string>& methods) {
  std::vector<Setting> settings;
  for (const SettingText& text : texts) {
    const bool is_there = std::find(methods.begin(), methods.end(), text.method) != methods.end();
    if (!is_there && std::string(text.method) != "auto") continue;
    Setting& setting = settings.emplace_back();
    setting.method = text.method;
    setting.label = absl::StrJoin(text.options, " ");
    setting.filter_radius = text.filter_radius;
    const bool is_adaptive = std::find(text.options.begin(), text.options.end(), "adaptive=true") != text.options.end();
    setting.family = absl::StrCat(text.method, is_adaptive ? " adaptive" : "");
    if (text.filter_radius > 0) {
      const int side = 2 * text.filter_radius + 1;
      absl::StrAppend(&setting.label, " filter ", side, "x", side);
      absl::StrAppend(&setting.family, " filtered");
    }
    const auto* field = v1::Method::descriptor()->FindFieldByName(text.method);
    google::protobuf::Message* options = setting.options.GetReflection()->MutableMessage(&setting.options, field);
    for (const std::string& option : text.options) {
      const size_t equals = option.find('=');
      const std::string key = option.substr(0, equals);
      if (key == "max_error") {  // of the request's budget
        setting.max_error = std::stod(option.substr(equals + 1));
        continue;
      }
      const auto* option_field = options->GetDescriptor()->FindFieldByName(key);
      if (option_field == nullptr) return absl::InternalError(absl::StrCat(text.method, " has no option ", key));
      RETURN_IF_ERROR(SetFieldFromText(options, *option_field, key, option.substr(equals + 1)));
    }
  }
  return settings;
}

// The baselines at the settings that a rival would be taken at; a method's own issue adds its rows.
const std::vector<SettingText>& FullSettings() {
  static const std::vector<SettingText> settings = {
      {"hard", {"map_size=1024"}},
      {"pcss", {"blocker_taps=7", "filter_taps=15"}},
      {"pcss", {"blocker_taps=7", "filter_taps=15", "skip=false"}},
      {"pcss", {"blocker_taps=11", "filter_taps=21"}},
      {"pcss", {"blocker_taps=29", "filter_taps=41"}},
      {"sssm", {"blocker_taps=11", "filter_taps=21", "weights=MEAN"}},
      {"sssm", {"blocker_taps=29", "filter_taps=41", "weights=MEAN"}},
      {"sssm", {"blocker_taps=29", "filter_taps=41"}},
      {"sssm", {"blocker_taps=11", "filter_taps=21", "weights=MEAN", "sub_lights=2"}},
      {"ssm", {}},
      {"ssm", {"sub_lights=1", "occluder_map_size=256"}},
      {"ssm", {"sub_lights=2", "occluder_map_size=256"}},
      {"ssm", {"sub_lights=3", "occluder_map_size=256"}},
      {"ssm", {"sub_lights=4", "occluder_map_size=512"}},
      {"multi_map", {"k=4", "map_size=512"}},
      {"multi_map", {"k=16", "map_size=512"}},
      {"multi_map", {"k=16", "map_size=1024"}},
      {"multi_map", {"k=64", "map_size=512"}},
      {"multi_map", {"k=64", "map_size=1024"}},
      {"pdsm", {"k=16"}},
      {"pdsm", {"k=64"}},
      {"pdsm", {"k=256"}},
      {"pdsm", {"k=64", "layout=INDEXED"}},
      {"pdsm", {"k=64", "layout=INDEXED", "eps=0.04"}},
      {"ray", {"rays=4"}},
      {"ray", {"rays=16"}},
      {"ray", {"rays=64"}},
      {"ray", {"rays=256"}},
      {"ray", {"rays=256", "adaptive=true", "stop_error=0.03"}},
      {"ray", {"rays=256", "adaptive=true", "stop_error=0.01"}},
      {"ray", {"rays=1024", "adaptive=true", "stop_error=0.003"}},
      {"shaft", {"rows=8"}},
      {"shaft", {"rows=16"}},
      {"shaft", {"rows=32"}},
      {"shaft", {"rows=64"}},
      {"auto", {"max_error=0.03"}},
      {"auto", {"max_error=0.01"}},
      {"auto", {"max_error=0.005"}},
      {"auto", {"max_error=0.002"}},
  };
  return settings;
}

const std::vector<SettingText>& QuickSettings() {
  static const std::vector<SettingText> settings = {
      {"hard", {"map_size=1024"}},
      {"pcss", {"blocker_taps=7", "filter_taps=15"}},
      {"sssm", {"blocker_taps=11", "filter_taps=21", "weights=MEAN", "sub_lights=2"}},
      {"ssm", {}},
      {"ssm", {"sub_lights=2", "occluder_map_size=256"}},
      {"multi_map", {"k=16", "map_size=512"}},
      {"multi_map", {"k=64", "map_size=512"}},
      {"pdsm", {"k=64"}},
      {"pdsm", {"k=64", "layout=INDEXED"}},
      {"ray", {"rays=4"}},
      {"ray", {"rays=16"}},
      {"ray", {"rays=64"}},
      {"ray", {"rays=256", "adaptive=true", "stop_error=0.01"}},
      {"shaft", {"rows=8"}},
      {"shaft", {"rows=16"}},
      {"shaft", {"rows=64"}},
      {"auto", {"max_error=0.01"}},
      {"auto", {"max_error=0.002"}},
  };
  return settings;
}

// Tables 2 to 6 of Buades et al. 2015: PCSS with and without its skip, SSSM at three thresholds, at three kernels.
std::vector<SettingText> SssmSettings() {
  std::vector<SettingText> settings;
  for (const auto& [blocker, filter] : {std::pair{7, 15}, std::pair{11, 21}, std::pair{29, 41}}) {
    const std::vector<std::string> kernel = {absl::StrCat("blocker_taps=", blocker),
                                             absl::StrCat("filter_taps=", filter), "weights=MEAN"};
    const auto add = [&](const char* method, std::vector<std::string> more) {
      more.insert(more.begin(), kernel.begin(), kernel.end());
      settings.push_back({method, std::move(more)});
    };
    add("pcss", {"skip=false"});
    add("pcss", {});
    for (const char* threshold : {"0.01", "0.1", "0.5"}) {
      add("sssm", {absl::StrCat("alpha=", threshold), absl::StrCat("beta=", threshold)});
    }
    add("sssm", {"sub_lights=2"});
  }
  const std::vector<std::string> large = {"blocker_taps=29", "filter_taps=41"};
  settings.push_back({"ssm", {"sub_lights=1", "occluder_map_size=512"}});
  settings.push_back({"pcss", {large[0], large[1], "map_size=4096"}});
  settings.push_back({"sssm", {large[0], large[1], "map_size=4096", "weights=MEAN"}});
  return settings;
}

// SHAFT and whatever a user would take instead.
std::vector<SettingText> ShaftSettings() {
  std::vector<SettingText> settings;
  for (const char* rows : {"rows=8", "rows=16", "rows=32", "rows=64"}) {
    settings.push_back({"shaft", {rows}});
    settings.push_back({"shaft", {rows, "sparse=true"}});
  }
  for (const char* rays : {"rays=1", "rays=4", "rays=16"}) {
    settings.push_back({"ray", {rays}});
    settings.push_back({"ray", {rays}, 1});
    settings.push_back({"ray", {rays}, 2});
  }
  for (const char* rays : {"rays=64", "rays=256", "rays=1024"}) settings.push_back({"ray", {rays}});
  for (const char* stop : {"stop_error=0.03", "stop_error=0.01", "stop_error=0.003", "stop_error=0.001"}) {
    settings.push_back({"ray", {"rays=1024", "adaptive=true", stop}});
  }
  for (const char* k : {"k=4", "k=16", "k=64", "k=256"}) settings.push_back({"multi_map", {k, "map_size=512"}});
  settings.push_back({"multi_map", {"k=64", "map_size=256"}});
  settings.push_back({"pcss", {"blocker_taps=7", "filter_taps=15", "map_size=512"}});
  settings.push_back({"pcss", {"blocker_taps=7", "filter_taps=15"}});
  settings.push_back({"pcss", {"blocker_taps=11", "filter_taps=21"}});
  settings.push_back({"pcss", {"blocker_taps=29", "filter_taps=41"}});
  return settings;
}

// Table 6: Gaussian weights, against lights that are weighed alike.
std::vector<SettingText> GaussianSettings() {
  const std::vector<std::string> large = {"blocker_taps=29", "filter_taps=41", "weights=GAUSSIAN"};
  std::vector<SettingText> settings = {{"pcss", large}};
  for (const char* threshold : {"0.01", "0.1", "0.5"}) {
    SettingText& sssm = settings.emplace_back(SettingText{"sssm", large});
    sssm.options.push_back(absl::StrCat("alpha=", threshold));
    sssm.options.push_back(absl::StrCat("beta=", threshold));
  }
  return settings;
}

// Forms of the functions, beside the maps that they are made of.
const std::vector<SettingText>& PdsmSettings() {
  static const std::vector<SettingText> settings = {
      {"multi_map", {"k=16", "map_size=512"}},
      {"multi_map", {"k=64", "map_size=512"}},
      {"pdsm", {"k=16"}},
      {"pdsm", {"k=64"}},
      {"pdsm", {"k=256"}},
      {"pdsm", {"k=16", "layout=INDEXED"}},
      {"pdsm", {"k=64", "layout=INDEXED"}},
      {"pdsm", {"k=64", "layout=INDEXED", "eps=0.02"}},
      {"pdsm", {"k=64", "layout=INDEXED", "eps=0.04"}},
      {"pdsm", {"k=256", "layout=INDEXED"}},
      {"pdsm", {"k=64", "surface_only=true"}},
      {"pdsm", {"k=16", "soft_events=true"}},
      {"pdsm", {"k=16", "soft_events=true", "eps=0.01"}},
      {"pdsm", {"k=64", "soft_events=true"}},
  };
  return settings;
}

// On receivers alone: SSM's settings, each rival's at the sizes that it is cheapest at, and the paper's own form.
std::vector<SettingText> SsmSettings() {
  return {{"hard", {"map_size=1024"}},
          {"pcss", {"blocker_taps=11", "filter_taps=21"}},
          {"ssm", {}},
          {"ssm", {"sub_lights=1", "occluder_map_size=256"}},
          {"ssm", {"sub_lights=2", "occluder_map_size=256"}},
          {"ssm", {"sub_lights=4", "occluder_map_size=256"}},
          {"ssm", {"sub_lights=4", "occluder_map_size=512"}},
          {"ssm", {"sub_lights=4", "occluder_map_size=256", "resolve=MAP"}},
          {"ssm", {"sub_lights=1", "occluder_map_size=256", "resolve=MAP", "coverage=false"}},
          {"ssm", {"accumulation=SCATTER", "occluder_map_size=256"}},
          {"multi_map", {"k=16", "map_size=256"}},
          {"multi_map", {"k=16", "map_size=512"}},
          {"multi_map", {"k=64", "map_size=256"}},
          {"multi_map", {"k=64", "map_size=512"}},
          {"multi_map", {"k=256", "map_size=512"}},
          {"ray", {"rays=16"}},
          {"ray", {"rays=64"}},
          {"ray", {"rays=256"}},
          {"ray", {"rays=1024"}}};
}

// Atty et al. 2006, as printed: one view of the light, a soft shadow map of 512 x 512, and what takes the scatter's
// place at the same patches.
const SettingText kScatter = {"ssm", {"accumulation=SCATTER"}};
const SettingText kScatterTwice = {"ssm", {"accumulation=SCATTER", "passes=2"}};
const SettingText kBinnedMap = {"ssm", {"resolve=MAP", "sub_lights=1", "coverage=false"}};

const std::vector<SettingText>& CurveSettings() {
  static const std::vector<SettingText> settings = {
      {"hard", {"map_size=1024"}},
      {"pcss", {"blocker_taps=7", "filter_taps=15"}},
      {"ssm", {"sub_lights=2", "occluder_map_size=256"}},
      {"multi_map", {"k=16", "map_size=512"}},
      {"pdsm", {"k=16"}},
      {"ray", {"rays=16"}},
      {"ray", {"rays=256", "adaptive=true", "stop_error=0.01"}},
      {"shaft", {"rows=16"}},
  };
  return settings;
}

void SetVec3(const glm::dvec3& from, v1::Vec3* to) {
  to->set_x(from.x);
  to->set_y(from.y);
  to->set_z(from.z);
}

// The scene's own request, on the wire.
v1::RenderRequest ToProto(const RenderRequest& plain) {
  v1::RenderRequest request;
  v1::LookAt* camera = request.mutable_camera()->mutable_look_at();
  SetVec3(plain.camera.eye_ws, camera->mutable_eye());
  SetVec3(plain.camera.target_ws, camera->mutable_target());
  SetVec3(plain.camera.up_ws, camera->mutable_up());
  camera->set_fovy_deg(std::atan(plain.camera.tan_half_fovy) * 360 / M_PI);
  for (const AreaLight& light : plain.lights) {
    v1::AreaLight* out = request.add_lights();
    SetVec3(light.center_ws, out->mutable_center());
    SetVec3(light.axis_u_ws * light.width_m, out->mutable_edge_u());
    SetVec3(light.axis_v_ws * light.height_m, out->mutable_edge_v());
  }
  if (plain.ground) {
    request.mutable_ground()->set_height_m(plain.ground->height_m);
    request.mutable_ground()->set_size_m(plain.ground->size_m);
  }
  return request;
}

struct MadeCase {
  const char* scene;
  double light_share = 0.2;
  uint32_t triangles = 0;
  uint32_t width = kWidth, height = kHeight;
  int lights = 1;
  bool receivers_alone = false;  // what casts has no shadow: errors and costs are those of the ground
  glm::dvec3 moved_m{0};         // what casts
};

Case MakeCase(const MadeCase& made) {
  SceneOptions options;
  options.light_share = made.light_share;
  options.triangles = made.triangles;
  const MadeScene scene = MakeScene(made.scene, options);
  Case result;
  result.name = absl::StrFormat("%s light %g", made.scene, made.light_share);
  result.files.root.bytes = WriteGlb(scene.meshes);
  result.files.root.digest = Sha256Hex(result.files.root.bytes);
  result.files.name = SceneName(result.files.root.digest, {});
  result.request = ToProto(RequestFor(scene));
  for (int i = 1; i < made.lights; ++i) {
    *result.request.add_lights() = result.request.lights(0);
    v1::Vec3* center = result.request.mutable_lights(i)->mutable_center();
    center->set_x(center->x() + 0.1 * i);
  }
  for (uint32_t node = 0; made.receivers_alone && node < scene.meshes.size(); ++node) {
    v1::NodeOverride* caster = result.request.add_node_overrides();
    caster->set_index(node);
    caster->set_receives(false);
    if (made.moved_m == glm::dvec3(0)) continue;
    const glm::mat4 moved = glm::translate(glm::mat4(1), glm::vec3(made.moved_m));
    caster->mutable_transform()->Add(&moved[0][0], &moved[0][0] + 16);
  }
  result.request.set_scene(result.files.name);
  result.request.set_width(made.width);
  result.request.set_height(made.height);
  return result;
}

Case Weighed(Case bench_case, const std::vector<Setting>& settings) {
  bench_case.name += ", Gaussian";
  bench_case.is_gaussian = true;
  bench_case.settings = settings;
  return bench_case;
}

// The same settings at every step.
CurvePlan MakeCurve(const std::string& work, const std::vector<std::pair<double, MadeCase>>& steps,
                    const std::vector<Setting>& settings) {
  CurvePlan plan;
  plan.work = work;
  for (const auto& [x, made] : steps) plan.steps.push_back({x, MakeCase(made), settings});
  return plan;
}

// The same case in settings of another value of one option. `texts` without it; those are the curves' names.
absl::StatusOr<CurvePlan> MakeOptionCurve(const std::string& option, const std::vector<double>& values,
                                          const MadeCase& made, const std::vector<SettingText>& texts,
                                          const std::vector<std::string>& methods) {
  CurvePlan plan;
  plan.work = option;
  plan.measures_error = true;
  ASSIGN_OR_RETURN(const std::vector<Setting> named, MakeSettings(texts, methods));
  for (const double value : values) {
    std::vector<SettingText> with_value = texts;
    for (SettingText& text : with_value) text.options.push_back(absl::StrCat(option, "=", value));
    CurvePlan::Step& step = plan.steps.emplace_back(CurvePlan::Step{value, MakeCase(made), {}});
    ASSIGN_OR_RETURN(step.settings, MakeSettings(with_value, methods));
    for (size_t i = 0; i < named.size(); ++i) step.settings[i].label = named[i].label;
  }
  return plan;
}

// The figures of Atty et al. 2006 as curves, errors on receivers.
absl::StatusOr<std::vector<CurvePlan>> SsmCurves(const std::vector<std::string>& methods) {
  std::vector<CurvePlan> curves;
  const std::vector<double> sizes = {32, 64, 128, 192, 256, 384, 512};
  const std::vector<SettingText> paper = {kScatter, kScatterTwice, kBinnedMap};
  // Figure 17, and the price of the second pass.
  for (const char* scene : {"S1", "S2"}) {
    ASSIGN_OR_RETURN(curves.emplace_back(), MakeOptionCurve("occluder_map_size", sizes,
                                                            {.scene = scene, .receivers_alone = true}, paper, methods));
    curves.back().work = absl::StrCat("occluder_map_size, ", scene);
  }
  // Beyond the paper: cells of the light, both layers of each, and what the scatter lacks, the sum to one.
  for (const char* scene : {"S2", "S3", "S5"}) {
    ASSIGN_OR_RETURN(curves.emplace_back(),
                     MakeOptionCurve("sub_lights", {1, 2, 4}, {.scene = scene, .receivers_alone = true},
                                     {{"ssm", {"occluder_map_size=256"}},
                                      {"ssm", {"occluder_map_size=256", "passes=2"}},
                                      {"ssm", {"occluder_map_size=256", "accumulation=SCATTER", "coverage=true"}}},
                                     methods));
    curves.back().work = absl::StrCat("sub_lights, ", scene);
  }
  // Figure 14: formats.
  ASSIGN_OR_RETURN(curves.emplace_back(), MakeOptionCurve("occluder_map_size", {128, 256, 512},
                                                          {.scene = "S2", .light_share = 0.5, .receivers_alone = true},
                                                          {{"ssm", {"accumulation=SCATTER", "blend=FP32"}},
                                                           {"ssm", {"accumulation=SCATTER", "blend=FP16"}},
                                                           {"ssm", {"accumulation=SCATTER", "blend=FP16_BATCHED"}}},
                                                          methods));
  curves.back().work = "occluder_map_size, formats, light .5";
  // Figures 18 to 20, 22 to 24: the light's size, the occluder's place, polygons.
  const std::vector<SettingText> sized = {
      {"ssm", {"accumulation=SCATTER", "occluder_map_size=256"}},
      {"ssm", {"accumulation=SCATTER", "occluder_map_size=128"}},
      {"ssm", {"resolve=MAP", "sub_lights=1", "coverage=false", "occluder_map_size=256"}},
      {"ssm", {"sub_lights=2", "occluder_map_size=256"}}};
  ASSIGN_OR_RETURN(const std::vector<Setting> settings, MakeSettings(sized, methods));
  std::vector<std::pair<double, MadeCase>> lights, sideways, upwards, polygons;
  for (const double share : {0.01, 0.05, 0.1, 0.2, 0.5, 1.0}) {
    lights.push_back({share, {.scene = "S2", .light_share = share, .receivers_alone = true}});
  }
  for (const double x : {0.01, 0.2, 0.4, 0.8, 1.2}) {
    sideways.push_back({x, {.scene = "S2", .receivers_alone = true, .moved_m = {x, 0, 0}}});
  }
  for (const double y : {0.01, 0.2, 0.4, 0.8, 1.2}) {
    upwards.push_back({y, {.scene = "S2", .receivers_alone = true, .moved_m = {0, y, 0}}});
  }
  for (const uint32_t count : {1000u, 10000u, 100000u, 340000u}) {
    polygons.push_back({double(count), {.scene = "S6", .triangles = count, .receivers_alone = true}});
  }
  curves.push_back(MakeCurve("light size, S2", lights, settings));
  curves.push_back(MakeCurve("metres sideways, S2", sideways, settings));
  curves.push_back(MakeCurve("metres upwards, S2", upwards, settings));
  curves.push_back(MakeCurve("triangles, S6", polygons, settings));
  for (CurvePlan& curve : curves) {
    curve.measures_error = true;
    curve.repetitions = 1;  // of seconds each
  }
  return curves;
}

// Against triangles, light size, pixels and lights.
std::vector<CurvePlan> WorkCurves(const std::vector<Setting>& settings) {
  std::vector<CurvePlan> curves;
  curves.push_back(MakeCurve("triangles",
                             {{1e3, {.scene = "S6", .triangles = 1000}},
                              {1e4, {.scene = "S6", .triangles = 10000}},
                              {1e5, {.scene = "S6", .triangles = 100000}},
                              {1e6, {.scene = "S6", .triangles = 1000000}}},
                             settings));
  curves.push_back(MakeCurve("light size",
                             {{0.01, {.scene = "S5", .light_share = 0.01}},
                              {0.05, {.scene = "S5", .light_share = 0.05}},
                              {0.2, {.scene = "S5", .light_share = 0.2}},
                              {1, {.scene = "S5", .light_share = 1}}},
                             settings));
  curves.back().measures_error = true;
  curves.push_back(MakeCurve("pixels",
                             {{57600, {.scene = "S5", .width = 320, .height = 180}},
                              {230400, {.scene = "S5", .width = 640, .height = 360}},
                              {921600, {.scene = "S5", .width = 1280, .height = 720}}},
                             settings));
  curves.push_back(MakeCurve("lights",
                             {{1, {.scene = "S5", .width = 320, .height = 180}},
                              {4, {.scene = "S5", .width = 320, .height = 180, .lights = 4}},
                              {16, {.scene = "S5", .width = 320, .height = 180, .lights = 16}}},
                             settings));
  return curves;
}

absl::StatusOr<std::vector<CurvePlan>> FullCurves(const std::vector<std::string>& methods) {
  ASSIGN_OR_RETURN(const std::vector<Setting> settings, MakeSettings(CurveSettings(), methods));
  std::vector<CurvePlan> curves = WorkCurves(settings);
  ASSIGN_OR_RETURN(CurvePlan map_size, MakeOptionCurve("map_size", {128, 256, 512, 1024, 2048, 4096}, {.scene = "S2"},
                                                       {{"hard", {}}, {"pcss", {}}, {"multi_map", {"k=16"}}}, methods));
  curves.push_back(std::move(map_size));
  return curves;
}

absl::StatusOr<Case> CaseOfView(const fs::path& view) {
  Case result;
  result.name = view.stem().string();
  RETURN_IF_ERROR(ApplyViewFile(view.string(), &result.request));
  ASSIGN_OR_RETURN(result.files, ReadSceneFiles(result.request.scene()));
  result.request.set_scene(result.files.name);
  result.request.set_width(kWidth);
  result.request.set_height(kHeight);
  return result;
}

}  // namespace

absl::StatusOr<Suite> MakeSuite(const std::string& name, const std::vector<std::string>& methods,
                                const std::string& scene_folder) {
  Suite suite;
  if (name == "quick") {
    for (const char* scene : {"S1", "S2", "S3", "S5"}) suite.cases.push_back(MakeCase({.scene = scene}));
    ASSIGN_OR_RETURN(suite.settings, MakeSettings(QuickSettings(), methods));
    suite.effort.reference_rays = 2048;
    return suite;
  }
  if (name == "sssm") {
    for (const double share : {0.04, 0.1}) {
      suite.cases.push_back(MakeCase({.scene = "S5", .light_share = share, .width = 1280, .height = 720}));
    }
    if (!scene_folder.empty()) {
      ASSIGN_OR_RETURN(Case trees, CaseOfView(fs::path(scene_folder) / "views" / "trees_masked.json"));
      trees.request.set_width(1280);
      trees.request.set_height(720);
      suite.cases.push_back(std::move(trees));
    }
    ASSIGN_OR_RETURN(suite.settings, MakeSettings(SssmSettings(), methods));
    ASSIGN_OR_RETURN(const std::vector<Setting> gaussian, MakeSettings(GaussianSettings(), methods));
    for (size_t i = 0, count = suite.cases.size(); i < count; ++i) {
      suite.cases.push_back(Weighed(suite.cases[i], gaussian));
    }
    suite.effort.reference_rays = 1024;
    suite.effort.measures_warm = false;
    return suite;
  }
  if (name == "shaft") {
    for (const char* scene : {"S1", "S2", "S3", "S4", "S5", "S6", "S7"}) {
      for (const double share : {0.05, 0.2, 0.5}) {
        suite.cases.push_back(MakeCase({.scene = scene, .light_share = share}));
        suite.cases.back().is_dense = std::string(scene) >= "S6";
      }
    }
    if (!scene_folder.empty()) {
      for (const char* view : {"spot", "graveyard", "camp", "trees_masked", "nefertiti", "flight_helmet"}) {
        ASSIGN_OR_RETURN(Case real, CaseOfView(fs::path(scene_folder) / "views" / absl::StrCat(view, ".json")));
        real.is_dense = std::string(view) == "nefertiti" || std::string(view) == "flight_helmet";
        suite.cases.push_back(std::move(real));
      }
    }
    ASSIGN_OR_RETURN(suite.settings, MakeSettings(ShaftSettings(), methods));
    ASSIGN_OR_RETURN(
        const std::vector<Setting> curve_settings,
        MakeSettings({{"shaft", {"rows=16"}}, {"shaft", {"rows=8", "sparse=true"}}, {"ray", {"rays=16"}}}, methods));
    suite.curves = WorkCurves(curve_settings);
    suite.effort = {.repetitions = 7, .reference_rays = 4096, .measures_warm = false};
    suite.judged = "shaft";
    return suite;
  }
  if (name == "pdsm") {
    for (const char* scene : {"S2", "S3", "S5"}) suite.cases.push_back(MakeCase({.scene = scene}));
    for (const char* view : {"trees_masked", "garage"}) {
      if (scene_folder.empty()) break;
      ASSIGN_OR_RETURN(Case real, CaseOfView(fs::path(scene_folder) / "views" / absl::StrCat(view, ".json")));
      suite.cases.push_back(std::move(real));
    }
    ASSIGN_OR_RETURN(suite.settings, MakeSettings(PdsmSettings(), methods));
    const std::vector<SettingText> forms = {{"pdsm", {}}, {"pdsm", {"layout=INDEXED"}}, {"pdsm", {"soft_events=true"}}};
    const std::pair<const char*, std::vector<double>> options[] = {
        {"k", {4, 16, 64, 256}}, {"map_size", {128, 256, 512, 1024}}, {"pdsm_size", {128, 256, 512, 1024}}};
    for (const auto& [option, values] : options) {
      ASSIGN_OR_RETURN(CurvePlan curve, MakeOptionCurve(option, values, {.scene = "S2"}, forms, methods));
      suite.curves.push_back(std::move(curve));
    }
    suite.effort = {.repetitions = 3, .reference_rays = 1024, .measures_warm = true};
    return suite;
  }
  if (name == "ssm") {
    for (const char* scene : {"S1", "S2", "S3", "S4", "S5"}) {
      for (const double share : {0.05, 0.2, 0.5}) {
        suite.cases.push_back(MakeCase({.scene = scene, .light_share = share, .receivers_alone = true}));
      }
    }
    ASSIGN_OR_RETURN(suite.settings, MakeSettings(SsmSettings(), methods));
    ASSIGN_OR_RETURN(suite.curves, SsmCurves(methods));
    suite.effort.repetitions = 3;
    suite.effort.measures_warm = false;
    return suite;
  }
  if (name != "full") {
    return UsageError(absl::StrCat("--suite: '", name, "'; there are quick, full, pdsm, shaft, ssm and sssm"));
  }
  for (const char* scene : {"S1", "S2", "S3", "S4", "S5", "S6"}) {
    for (const double share : {0.05, 0.2, 0.5}) suite.cases.push_back(MakeCase({.scene = scene, .light_share = share}));
  }
  suite.cases.push_back(MakeCase({.scene = "S7"}));
  if (!scene_folder.empty()) {
    // Everyday models of 3 k to 100 k triangles, and two with alpha masks or a room around the light.
    for (const char* view : {"spot", "graveyard", "camp", "garage", "trees_masked", "nefertiti", "flight_helmet"}) {
      ASSIGN_OR_RETURN(Case real, CaseOfView(fs::path(scene_folder) / "views" / absl::StrCat(view, ".json")));
      suite.cases.push_back(std::move(real));
    }
  }
  ASSIGN_OR_RETURN(suite.settings, MakeSettings(FullSettings(), methods));
  ASSIGN_OR_RETURN(suite.curves, FullCurves(methods));
  return suite;
}

absl::StatusOr<Suite> MakeSmokeSuite(const std::vector<std::string>& methods) {
  Suite suite;
  suite.cases.push_back(MakeCase({.scene = "S3", .width = 64, .height = 36}));
  ASSIGN_OR_RETURN(const std::vector<Setting> gaussian, MakeSettings(GaussianSettings(), methods));
  suite.cases.push_back(Weighed(suite.cases[0], gaussian));
  ASSIGN_OR_RETURN(suite.settings, MakeSettings(FullSettings(), methods));
  ASSIGN_OR_RETURN(const std::vector<Setting> curve_settings, MakeSettings(CurveSettings(), methods));
  suite.curves.push_back(MakeCurve(
      "pixels", {{576, {.scene = "S3", .width = 32, .height = 18}}, {2304, {.scene = "S3", .width = 64, .height = 36}}},
      curve_settings));
  ASSIGN_OR_RETURN(
      CurvePlan map_size,
      MakeOptionCurve("map_size", {64, 128}, {.scene = "S3", .width = 64, .height = 36}, {{"hard", {}}}, methods));
  suite.curves.push_back(std::move(map_size));
  ASSIGN_OR_RETURN(const std::vector<Setting> filtered, MakeSettings({{"ray", {"rays=4"}, 2}}, methods));
  suite.settings.insert(suite.settings.end(), filtered.begin(), filtered.end());
  suite.effort = {.repetitions = 1, .reference_rays = 64, .measures_warm = true};
  suite.judged = "shaft";
  return suite;
}

absl::StatusOr<Suite> MakeSceneSuite(const std::vector<std::string>& paths, const std::vector<std::string>& methods) {
  Suite suite;
  for (const std::string& path : paths) {
    if (fs::path(path).extension() == ".json") {
      ASSIGN_OR_RETURN(Case view, CaseOfView(path));
      suite.cases.push_back(std::move(view));
      continue;
    }
    Case& own = suite.cases.emplace_back();
    own.name = fs::path(path).stem().string();
    ASSIGN_OR_RETURN(own.files, ReadSceneFiles(path));
    own.request.set_scene(own.files.name);
    own.request.set_width(kWidth);
    own.request.set_height(kHeight);
  }
  ASSIGN_OR_RETURN(suite.settings, MakeSettings(FullSettings(), methods));
  return suite;
}

}  // namespace halfshade::bench
