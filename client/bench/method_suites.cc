#include "client/bench/method_suites.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "client/bench/cases.h"
#include "renderer/status.h"

namespace halfshade::bench {
namespace {

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

// SHAFT and whatever a user would take instead, in settings that have been the cheapest at one of the four errors of
// fractions.h, or stand beside such a one. `is_dense`: a map draws every triangle, so that sixteen of them cost more
// than 256 rays a pixel: they are left out.
std::vector<SettingText> ShaftSettings(bool is_dense) {
  std::vector<SettingText> settings;
  for (const char* rows : {"rows=8", "rows=16", "rows=32"}) {
    settings.push_back({"shaft", {rows}});
    settings.push_back({"shaft", {rows, "sparse=true"}});
  }
  settings.push_back({"shaft", {"rows=64"}});
  for (const char* rays : {"rays=4", "rays=16", "rays=64", "rays=256", "rays=1024"}) {
    settings.push_back({"ray", {rays}});
  }
  for (const auto& [rays, radius] : {std::pair{"rays=1", 2}, {"rays=4", 1}, {"rays=4", 2}, {"rays=16", 1}}) {
    settings.push_back({"ray", {rays}, radius});
  }
  for (const char* stop : {"stop_error=0.01", "stop_error=0.003", "stop_error=0.001"}) {
    settings.push_back({"ray", {"rays=1024", "adaptive=true", stop}});
  }
  if (!is_dense) {
    for (const char* k : {"k=4", "k=16", "k=64"}) settings.push_back({"multi_map", {k, "map_size=512"}});
  }
  settings.push_back({"pcss", {"blocker_taps=7", "filter_taps=15", "map_size=512"}});
  settings.push_back({"pcss", {"blocker_taps=11", "filter_taps=21"}});
  return settings;
}

// AUTO at its budgets, each rival at the settings that it is cheapest at, and our own methods.
std::vector<SettingText> AutoSettings() {
  return {{"auto", {"max_error=0.03"}},
          {"auto", {"max_error=0.01"}},
          {"auto", {"max_error=0.005"}},
          {"auto", {"max_error=0.002"}},
          {"ray", {"rays=4"}},
          {"ray", {"rays=4"}, 2},
          {"ray", {"rays=16"}},
          {"ray", {"rays=16"}, 1},
          {"ray", {"rays=64"}},
          {"ray", {"rays=256"}},
          {"ray", {"rays=1024", "adaptive=true", "stop_error=0.03"}},
          {"ray", {"rays=1024", "adaptive=true", "stop_error=0.01"}},
          {"ray", {"rays=1024", "adaptive=true", "stop_error=0.002"}},
          {"multi_map", {"k=4", "map_size=512"}},
          {"multi_map", {"k=16", "map_size=512"}},
          {"multi_map", {"k=64", "map_size=512"}},
          {"pcss", {"blocker_taps=7", "filter_taps=15", "map_size=512"}},
          {"pcss", {"blocker_taps=11", "filter_taps=21"}},
          {"ray", {"rays=65536", "adaptive=true", "max_error=0.03"}},
          {"ray", {"rays=65536", "adaptive=true", "max_error=0.01"}},
          {"ray", {"rays=65536", "adaptive=true", "max_error=0.005"}},
          {"ray", {"rays=65536", "adaptive=true", "max_error=0.002"}},
          {"shaft", {"rows=4"}},
          {"shaft", {"rows=8"}},
          {"shaft", {"rows=16"}},
          {"shaft", {"rows=32"}},
          {"shaft", {"rows=64"}},
          {"ssm", {"sub_lights=1", "occluder_map_size=256"}},
          {"ssm", {"sub_lights=2", "occluder_map_size=256"}},
          {"ssm", {"sub_lights=4", "occluder_map_size=512"}},
          {"pdsm", {"k=64"}},
          {"sssm", {"blocker_taps=11", "filter_taps=21", "weights=MEAN", "sub_lights=2"}}};
}

// Everyday models of 3 k to 100 k triangles.
absl::StatusOr<std::vector<Case>> RealCases(const std::string& scene_folder) {
  ASSIGN_OR_RETURN(std::vector<Case> cases, CasesOfViews(scene_folder, {"spot", "graveyard", "camp", "trees_masked",
                                                                        "nefertiti", "flight_helmet"}));
  for (Case& view : cases) view.is_dense = view.name == "nefertiti" || view.name == "flight_helmet";
  return cases;
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

}  // namespace

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

absl::StatusOr<Suite> MakeSsmSuite(const std::vector<std::string>& methods) {
  Suite suite;
  for (const char* scene : {"S1", "S2", "S3", "S4", "S5"}) {
    for (const double share : {0.05, 0.2, 0.5}) {
      suite.cases.push_back(MakeCase({.scene = scene, .light_share = share, .receivers_alone = true}));
    }
  }
  // With what shadows itself.
  for (const char* scene : {"S2", "S5", "S6"}) {
    suite.cases.push_back(MakeCase({.scene = scene}));
    suite.cases.back().name += ", all pixels";
  }
  ASSIGN_OR_RETURN(suite.settings, MakeSettings(SsmSettings(), methods));
  ASSIGN_OR_RETURN(suite.curves, SsmCurves(methods));
  suite.effort.repetitions = 3;
  suite.effort.measures_warm = false;
  return suite;
}

absl::StatusOr<Suite> MakeSssmSuite(const std::vector<std::string>& methods, const std::string& scene_folder) {
  Suite suite;
  for (const double share : {0.04, 0.1}) {
    suite.cases.push_back(MakeCase({.scene = "S5", .light_share = share, .width = 1280, .height = 720}));
  }
  ASSIGN_OR_RETURN(const std::vector<Case> real, CasesOfViews(scene_folder, {"trees_masked"}));
  for (const Case& trees : real) {
    suite.cases.push_back(trees);
    suite.cases.back().request.set_width(1280);
    suite.cases.back().request.set_height(720);
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

absl::StatusOr<Suite> MakePdsmSuite(const std::vector<std::string>& methods, const std::string& scene_folder) {
  Suite suite;
  for (const char* scene : {"S2", "S3", "S5", "S6"}) suite.cases.push_back(MakeCase({.scene = scene}));
  ASSIGN_OR_RETURN(const std::vector<Case> real, CasesOfViews(scene_folder, {"trees_masked", "garage"}));
  suite.cases.insert(suite.cases.end(), real.begin(), real.end());
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

absl::StatusOr<Suite> MakeShaftSuite(const std::vector<std::string>& methods, const std::string& scene_folder) {
  Suite suite;
  for (const char* scene : {"S1", "S2", "S3", "S4", "S5", "S6", "S7"}) {
    for (const double share : {0.05, 0.2, 0.5}) {
      suite.cases.push_back(MakeCase({.scene = scene, .light_share = share}));
      suite.cases.back().is_dense = std::string(scene) >= "S6";
    }
  }
  ASSIGN_OR_RETURN(const std::vector<Case> real, RealCases(scene_folder));
  suite.cases.insert(suite.cases.end(), real.begin(), real.end());
  ASSIGN_OR_RETURN(suite.settings, MakeSettings(ShaftSettings(/*is_dense=*/false), methods));
  ASSIGN_OR_RETURN(const std::vector<Setting> dense, MakeSettings(ShaftSettings(/*is_dense=*/true), methods));
  for (Case& each : suite.cases) {
    if (each.is_dense) each.settings = dense;
  }
  ASSIGN_OR_RETURN(
      const std::vector<Setting> curve_settings,
      MakeSettings({{"shaft", {"rows=16"}}, {"shaft", {"rows=8", "sparse=true"}}, {"ray", {"rays=16"}}}, methods));
  suite.curves = WorkCurves(curve_settings);
  suite.effort = {.repetitions = 3, .reference_rays = 4096, .measures_warm = false};
  suite.judged = "shaft";
  return suite;
}

absl::StatusOr<Suite> MakeAutoSuite(const std::vector<std::string>& methods, const std::string& scene_folder) {
  Suite suite;
  for (const char* scene : {"S1", "S2", "S3", "S4", "S5", "S6", "S7"}) {
    for (const double share : {0.05, 0.2, 0.5}) {
      suite.cases.push_back(MakeCase({.scene = scene, .light_share = share}));
      suite.cases.back().is_dense = std::string(scene) >= "S6";
    }
  }
  ASSIGN_OR_RETURN(const std::vector<Case> real, RealCases(scene_folder));
  suite.cases.insert(suite.cases.end(), real.begin(), real.end());
  ASSIGN_OR_RETURN(suite.settings, MakeSettings(AutoSettings(), methods));
  // What stands between light and receivers is lifted behind the light: nothing is left to do.
  const std::vector<SettingText> exact = {{"auto", {"max_error=0.002"}}};
  ASSIGN_OR_RETURN(const std::vector<Setting> curve_settings, MakeSettings(exact, methods));
  for (const char* scene : {"S2", "S5"}) {
    suite.curves.push_back(MakeCurve(absl::StrCat("metres upwards, ", scene),
                                     {{0.01, {.scene = scene, .receivers_alone = true, .moved_m = {0, 0.01, 0}}},
                                      {100, {.scene = scene, .receivers_alone = true, .moved_m = {0, 100, 0}}}},
                                     curve_settings));
  }
  std::vector<Case> lasting = {MakeCase({.scene = "S2"}), MakeCase({.scene = "S5"}), MakeCase({.scene = "S6"})};
  for (const Case& view : real) {
    if (view.name == "graveyard") lasting.push_back(view);
  }
  for (Case& each : lasting) {
    each.request.set_width(512);
    each.request.set_height(512);
    suite.sequences.push_back(ScatterCameras(each, 100));
    each.request.set_width(1280);
    each.request.set_height(720);
    suite.sequences.push_back(DragLight(each, 60));
    suite.sequences.push_back(OrbitCamera(each, 60));
    suite.replies.push_back(each);
  }
  suite.effort = {.repetitions = 5, .reference_rays = 2048, .measures_warm = false};
  suite.judged = "auto";
  return suite;
}

}  // namespace halfshade::bench
