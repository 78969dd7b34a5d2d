#include "client/bench/suites.h"

#include <absl/strings/str_cat.h>

#include <filesystem>
#include <utility>

#include "client/bench/cases.h"
#include "client/bench/method_suites.h"
#include "client/exit_code.h"
#include "renderer/status.h"

namespace halfshade::bench {
namespace {

namespace fs = std::filesystem;

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

absl::StatusOr<std::vector<CurvePlan>> FullCurves(const std::vector<std::string>& methods) {
  ASSIGN_OR_RETURN(const std::vector<Setting> settings, MakeSettings(CurveSettings(), methods));
  std::vector<CurvePlan> curves = WorkCurves(settings);
  ASSIGN_OR_RETURN(CurvePlan map_size, MakeOptionCurve("map_size", {128, 256, 512, 1024, 2048, 4096}, {.scene = "S2"},
                                                       {{"hard", {}}, {"pcss", {}}, {"multi_map", {"k=16"}}}, methods));
  curves.push_back(std::move(map_size));
  return curves;
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
  if (name == "auto") return MakeAutoSuite(methods, scene_folder);
  if (name == "sssm") return MakeSssmSuite(methods, scene_folder);
  if (name == "shaft") return MakeShaftSuite(methods, scene_folder);
  if (name == "pdsm") return MakePdsmSuite(methods, scene_folder);
  if (name == "ssm") return MakeSsmSuite(methods);
  if (name != "full") {
    return UsageError(absl::StrCat("--suite: '", name, "'; there are auto, quick, full, pdsm, shaft, ssm and sssm"));
  }
  for (const char* scene : {"S1", "S2", "S3", "S4", "S5", "S6"}) {
    for (const double share : {0.05, 0.2, 0.5}) suite.cases.push_back(MakeCase({.scene = scene, .light_share = share}));
  }
  suite.cases.push_back(MakeCase({.scene = "S7"}));
  // Everyday models of 3 k to 100 k triangles, and two with alpha masks or a room around the light.
  ASSIGN_OR_RETURN(const std::vector<Case> real,
                   CasesOfViews(scene_folder,
                                {"spot", "graveyard", "camp", "garage", "trees_masked", "nefertiti", "flight_helmet"}));
  suite.cases.insert(suite.cases.end(), real.begin(), real.end());
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
  suite.sequences = {DragLight(suite.cases[0], 3), OrbitCamera(suite.cases[0], 3), ScatterCameras(suite.cases[0], 4)};
  suite.replies = {suite.cases[0]};
  suite.effort = {.repetitions = 1, .reference_rays = 64, .measures_warm = true};
  suite.judged = "auto";
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
