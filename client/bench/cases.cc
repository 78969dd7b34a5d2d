#include "client/bench/cases.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <cmath>
#include <filesystem>
#include <glm/gtc/matrix_transform.hpp>

#include "client/view_file.h"
#include "renderer/status.h"
#include "server/digest.h"
#include "server/scene_name.h"
#include "tests/support/scene_makers.h"

namespace halfshade::bench {
namespace {

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

}  // namespace

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

CurvePlan MakeCurve(const std::string& work, const std::vector<std::pair<double, MadeCase>>& steps,
                    const std::vector<Setting>& settings) {
  CurvePlan plan;
  plan.work = work;
  for (const auto& [x, made] : steps) plan.steps.push_back({x, MakeCase(made), settings});
  return plan;
}

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

absl::StatusOr<Case> CaseOfView(const std::string& view) {
  Case result;
  result.name = std::filesystem::path(view).stem().string();
  RETURN_IF_ERROR(ApplyViewFile(view, &result.request));
  ASSIGN_OR_RETURN(result.files, ReadSceneFiles(result.request.scene()));
  result.request.set_scene(result.files.name);
  result.request.set_width(kWidth);
  result.request.set_height(kHeight);
  return result;
}

absl::StatusOr<std::vector<Case>> CasesOfViews(const std::string& scene_folder, const std::vector<std::string>& names) {
  std::vector<Case> cases;
  if (scene_folder.empty()) return cases;
  for (const std::string& name : names) {
    ASSIGN_OR_RETURN(Case real, CaseOfView(absl::StrCat(scene_folder, "/views/", name, ".json")));
    cases.push_back(std::move(real));
  }
  return cases;
}

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

}  // namespace halfshade::bench
