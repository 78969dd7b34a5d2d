#include "server/validate.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <map>
#include <utility>

#include "renderer/plan/choose_method.h"
#include "renderer/plan/framing.h"
#include "renderer/status.h"
#include "server/digest.h"
#include "server/report_to_proto.h"
#include "server/scene_name.h"
#include "server/validate_field.h"

namespace halfshade {
namespace {

constexpr uint32_t kDefaultWidth = 1280;
constexpr uint32_t kDefaultHeight = 720;
constexpr uint32_t kDefaultLightMapSize = 512;
constexpr uint32_t kMinLightMapSize = 16;
constexpr double kLargestTimeS = 1e6;
constexpr double kLargestDensity = 1e6;  // per metre: beyond, nothing is seen through a hair

uint32_t OrDefault(uint32_t value, uint32_t absent) { return value == 0 ? absent : value; }

std::string Indexed(const char* field, int index) { return std::string(field) + "[" + std::to_string(index) + "]"; }

// The kind and the format of one output. A shadow catcher's FRAME is told by its alpha.
absl::StatusOr<std::pair<OutputKind, OutputFormat>> CheckOutput(const std::string& field, const v1::Output& output,
                                                                int lights, bool is_catcher) {
  const auto kind = FromProto(output.kind());
  if (!kind) return FieldError(field + ".kind", std::to_string(output.kind()) + "; no such kind");
  const auto encoding = FromProto(output.encoding());
  if (!encoding) return FieldError(field + ".encoding", std::to_string(output.encoding()) + "; no such encoding");
  absl::StatusOr<OutputFormat> format = FormatOf(*kind, *encoding, lights, is_catcher);
  if (!format.ok()) return FieldError(field + ".encoding", std::string(format.status().message()));
  if (!output.layer().empty()) {
    const absl::Status status = SetLayer(output.layer(), &*format);
    if (!status.ok()) {
      return FieldError(field + ".layer", absl::StrCat("\"", absl::CHexEscape(output.layer().substr(0, 80)), "\"; ",
                                                       std::string(status.message())));
    }
  }
  return std::pair(*kind, *std::move(format));
}

// A soft shadow map belongs to one side of one light, and a request has one size for it. Lights that are not given are
// one.
absl::Status CheckLightMap(const std::string& field, const v1::Output& output, const v1::RenderRequest& request,
                           const Limits& limits, RenderRequest* plain) {
  if (request.lights_size() > 1) {
    return FieldError(field + ".kind", absl::StrCat("SOFT_SHADOW_MAP of ", request.lights_size(),
                                                    " lights; must be of one: ask for each in a request of its own"));
  }
  if (request.lights_size() == 1 && request.lights(0).two_sided()) {
    return FieldError(field + ".kind", "SOFT_SHADOW_MAP of a light with two sides; must be of one");
  }
  const uint32_t size = OrDefault(output.light_map_size(), kDefaultLightMapSize);
  RETURN_IF_ERROR(
      CheckRange(field + ".light_map_size", size, kMinLightMapSize, std::min(limits.image_width, limits.image_height)));
  const bool is_first =
      std::find(plain->outputs.begin(), plain->outputs.end(), OutputKind::kSoftShadowMap) == plain->outputs.end();
  if (!is_first && int(size) != plain->light_map_size) {
    return FieldError(field + ".light_map_size",
                      absl::StrCat(size, "; must be ", plain->light_map_size, ", as of the output before it"));
  }
  plain->light_map_size = int(size);
  return absl::OkStatus();
}

// Layers share a file, in which a channel's name stands once.
absl::Status CheckLayers(const std::vector<OutputFormat>& formats) {
  std::map<std::string, size_t> owners;
  for (size_t i = 0; i < formats.size(); ++i) {
    if (formats[i].layer.empty()) continue;
    for (const std::string& channel : formats[i].channels) {
      const auto [owner, is_new] = owners.emplace(channel, i);
      if (!is_new) {
        return FieldError(
            Indexed("outputs", int(i)) + ".layer",
            absl::StrCat("\"", formats[i].layer, "\"; outputs[", owner->second, "] has a channel ", channel, " too"));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status CheckSize(const v1::RenderRequest& request, const Limits& limits) {
  if (request.width() > limits.image_width) {
    return FieldError("width",
                      std::to_string(request.width()) + "; must be 1 to " + std::to_string(limits.image_width));
  }
  if (request.height() > limits.image_height) {
    return FieldError("height",
                      std::to_string(request.height()) + "; must be 1 to " + std::to_string(limits.image_height));
  }
  if (request.samples() != 0 && request.samples() != 1 && request.samples() != 4 && request.samples() != 8) {
    return FieldError("samples", std::to_string(request.samples()) + "; must be 1, 4 or 8");
  }
  return absl::OkStatus();
}

absl::Status CheckAnimationFields(const v1::RenderRequest& request) {
  RETURN_IF_ERROR(CheckFinite("animation.time_s", request.animation().time_s()));
  return CheckRange("animation.time_s", request.animation().time_s(), 0, kLargestTimeS);
}

absl::Status CheckBudget(const v1::Budget& budget, Budget* result) {
  if (budget.has_max_error()) {
    const double max_error = budget.max_error();
    RETURN_IF_ERROR(CheckFinite("budget.max_error", max_error));
    if (!(max_error > 0 && max_error < 1)) {
      return FieldError("budget.max_error", NumberText(max_error) + "; must be over 0 and below 1");
    }
    result->max_error = max_error;
  }
  if (budget.has_max_latency()) {
    const double ms = 1e3 * double(budget.max_latency().seconds()) + 1e-6 * budget.max_latency().nanos();
    if (!(ms >= 1 && ms <= 600'000)) {
      return FieldError("budget.max_latency", NumberText(ms / 1000) + " s; must be .001 to 600");
    }
    result->max_latency_ms = ms;
  }
  return absl::OkStatus();
}

// Bounds of api: a certificate of fewer pixels or rays says nothing, of more it is a render of its own.
absl::Status CheckCertify(const v1::RenderRequest& request, RenderRequest* result) {
  if (!request.has_certify()) return absl::OkStatus();
  RETURN_IF_ERROR(CheckRange("certify.pixels", request.certify().pixels(), 64, 1'000'000));
  RETURN_IF_ERROR(CheckRange("certify.rays", request.certify().rays(), 16, 65536));
  const bool has_visibility = std::any_of(result->outputs.begin(), result->outputs.end(), [](OutputKind kind) {
    return kind == OutputKind::kFrame || kind == OutputKind::kVisibility;
  });
  if (!has_visibility) return FieldError("certify", "asked of outputs without visibility; needs FRAME or VISIBILITY");
  result->certify = CertifyOptions{request.certify().pixels(), int(request.certify().rays())};
  return absl::OkStatus();
}

absl::Status CheckGround(const v1::Ground& ground) {
  RETURN_IF_ERROR(CheckFinite("ground.height_m", ground.height_m()));
  RETURN_IF_ERROR(CheckRange("ground.height_m", ground.height_m(), -kLargestLengthM, kLargestLengthM));
  return CheckLength("ground.size_m", ground.size_m());
}

absl::StatusOr<Fog> CheckFog(const v1::RenderRequest& request) {
  const v1::Fog& asked = request.fog();
  Fog fog;
  RETURN_IF_ERROR(CheckFinite("fog.density_per_m", asked.density_per_m()));
  RETURN_IF_ERROR(CheckRange("fog.density_per_m", asked.density_per_m(), 0, kLargestDensity));
  fog.density_per_m = asked.density_per_m();
  if (asked.has_albedo()) {
    const std::pair<const char*, float> channels[] = {{"fog.albedo.r", asked.albedo().r()},
                                                      {"fog.albedo.g", asked.albedo().g()},
                                                      {"fog.albedo.b", asked.albedo().b()}};
    for (int c = 0; c < 3; ++c) {
      RETURN_IF_ERROR(CheckFinite(channels[c].first, channels[c].second));
      RETURN_IF_ERROR(CheckRange(channels[c].first, channels[c].second, 0, 1));
      fog.albedo[c] = channels[c].second;
    }
  }
  RETURN_IF_ERROR(CheckFinite("fog.falloff_height_m", asked.falloff_height_m()));
  RETURN_IF_ERROR(CheckRange("fog.falloff_height_m", asked.falloff_height_m(), 0, kLargestLengthM));
  fog.falloff_height_m = asked.falloff_height_m();
  RETURN_IF_ERROR(CheckFinite("fog.ground_m", asked.ground_m()));
  RETURN_IF_ERROR(CheckRange("fog.ground_m", asked.ground_m(), -kLargestLengthM, kLargestLengthM));
  fog.ground_m = asked.ground_m();
  if (request.ground().shadow_catcher()) {
    return FieldError("fog", "with ground.shadow_catcher, whose picture has nothing behind it that fog could veil");
  }
  return fog;
}

absl::Status CheckShading(const v1::Shading& shading, Shading* result) {
  if (shading.has_ambient()) {
    ASSIGN_OR_RETURN(result->ambient, CheckRgb("shading.ambient", shading.ambient()));
  }
  if (shading.has_background()) {
    ASSIGN_OR_RETURN(result->background, CheckRgb("shading.background", shading.background()));
  }
  RETURN_IF_ERROR(CheckFinite("shading.exposure_ev", shading.exposure_ev()));
  RETURN_IF_ERROR(CheckRange("shading.exposure_ev", shading.exposure_ev(), -32, 32));
  result->exposure_ev = shading.exposure_ev();
  if (!v1::ToneMap_IsValid(shading.tone_map())) {
    return FieldError("shading.tone_map", std::to_string(shading.tone_map()) + "; no such tone map");
  }
  if (shading.tone_map() == v1::TONE_MAP_ACES) result->tone_map = ToneMap::kAces;
  if (shading.tone_map() == v1::TONE_MAP_NEUTRAL) result->tone_map = ToneMap::kNeutral;
  return absl::OkStatus();
}

// Everything that the fields alone decide; camera and lights that are not given are left to ValidateRender.
absl::StatusOr<ValidatedRender> CheckFields(const v1::RenderRequest& request, const Limits& limits) {
  ValidatedRender result;
  RenderRequest& plain = result.request;
  if (!IsSceneName(request.scene())) {
    return FieldError("scene",
                      absl::StrCat("\"", request.scene().substr(0, 80), "\"; must be scenes/ and 64 hex digits"));
  }
  RETURN_IF_ERROR(CheckSize(request, limits));
  RETURN_IF_ERROR(CheckAnimationFields(request));
  plain.width = int(OrDefault(request.width(), kDefaultWidth));
  plain.height = int(OrDefault(request.height(), kDefaultHeight));
  plain.samples = int(OrDefault(request.samples(), 1));
  plain.seed = request.seed();
  RETURN_IF_ERROR(CheckNodeOverrideFields(request));
  RETURN_IF_ERROR(CheckCameraFields(request.camera()));
  if (uint32_t(request.lights_size()) > limits.lights) {
    return FieldError("lights", std::to_string(request.lights_size()) + "; this server takes at most " +
                                    std::to_string(limits.lights));
  }
  for (int i = 0; i < request.lights_size(); ++i) {
    ASSIGN_OR_RETURN(const AreaLight light, CheckLight(Indexed("lights", i), request.lights(i)));
    plain.lights.push_back(light);
  }
  RETURN_IF_ERROR(CheckMethod(request.method(), &plain));
  RETURN_IF_ERROR(CheckBudget(request.budget(), &plain.budget));
  if (request.has_ground()) {
    RETURN_IF_ERROR(CheckGround(request.ground()));
    plain.ground = Ground{request.ground().height_m(), request.ground().size_m(), request.ground().shadow_catcher()};
  }
  if (request.has_fog()) {
    ASSIGN_OR_RETURN(plain.fog, CheckFog(request));
  }
  RETURN_IF_ERROR(CheckShading(request.shading(), &plain.shading));
  if (!v1::CacheMode_IsValid(request.cache())) {
    return FieldError("cache", std::to_string(request.cache()) + "; no such mode");
  }
  if (request.cache() == v1::CACHE_MODE_REFRESH) plain.cache = CacheMode::kRefresh;
  const int lights = std::max(1, request.lights_size());
  const bool is_catcher = request.ground().shadow_catcher();
  auto outputs = request.outputs();
  if (outputs.empty()) outputs.Add();
  for (int i = 0; i < outputs.size(); ++i) {
    ASSIGN_OR_RETURN(const auto output, CheckOutput(Indexed("outputs", i), outputs[i], lights, is_catcher));
    if (output.first == OutputKind::kSoftShadowMap) {
      RETURN_IF_ERROR(CheckLightMap(Indexed("outputs", i), outputs[i], request, limits, &plain));
    }
    plain.outputs.push_back(output.first);
    result.formats.push_back(output.second);
    result.reply_bytes +=
        UncompressedBytes(output.second, SizeOf(plain, output.first).x, SizeOf(plain, output.first).y);
  }
  RETURN_IF_ERROR(CheckLayers(result.formats));
  RETURN_IF_ERROR(CheckCertify(request, &plain));
  if (result.reply_bytes > limits.render_reply_bytes) {
    return absl::FailedPreconditionError("outputs: " + std::to_string(result.reply_bytes) +
                                         " bytes before compression; Render returns at most " +
                                         std::to_string(limits.render_reply_bytes) + ", use RenderStream");
  }
  return result;
}

}  // namespace

absl::Status CheckRenderFields(const v1::RenderRequest& request, const Limits& limits) {
  return CheckFields(request, limits).status();
}

absl::StatusOr<Motion> ResolveMotion(const v1::RenderRequest& request, const FlatScene& scene) {
  Motion motion;
  motion.morph_weights = scene.morph_weights;
  if (request.has_animation()) {
    const v1::Animation& asked = request.animation();
    if (asked.index() >= scene.animations.size()) {
      return FieldError("animation.index", std::to_string(asked.index()) + "; the scene has " +
                                               std::to_string(scene.animations.size()) + " animations");
    }
    motion = Animate(scene, {asked.index(), asked.time_s()});
  }
  ASSIGN_OR_RETURN(const std::vector<NodeOverride> overrides, ResolveNodeOverrides(request, scene));
  motion.overrides = Combine(motion.overrides, overrides);
  return motion;
}

absl::StatusOr<ValidatedRender> ValidateRender(const v1::RenderRequest& request, const FlatScene& scene,
                                               const Limits& limits, const Machine& machine) {
  ASSIGN_OR_RETURN(ValidatedRender result, CheckFields(request, limits));
  RenderRequest& plain = result.request;
  plain.budget.machine = machine;
  plain.expected_frames = request.expected_frames();
  plain.scene_index = request.has_scene_index() ? request.scene_index() : scene.default_scene;
  ASSIGN_OR_RETURN(Motion motion, ResolveMotion(request, scene));
  plain.node_overrides = std::move(motion.overrides);
  result.morph_weights = std::move(motion.morph_weights);
  ASSIGN_OR_RETURN(const Pose pose, BuildPose(scene, plain.scene_index, plain.node_overrides));
  const double aspect = double(plain.width) / plain.height;
  ASSIGN_OR_RETURN(plain.camera, ResolveCamera(request, scene, plain.node_overrides, pose.bounds_ws, aspect));
  for (int i = 0; i < request.lights_size(); ++i) {
    ResolveLight(request.lights(i), plain.camera.target_ws, &plain.lights[size_t(i)]);
  }
  // A scene that comes with nothing but itself gets what shows it: a light, and under it a ground for the shadow to
  // fall on.
  const bool is_bare = request.lights().empty() && !request.has_camera() && !request.has_ground();
  if (request.lights().empty()) plain.lights = {SuitingLight(pose.bounds_ws)};
  if (is_bare) plain.ground = SuitingGround(pose.bounds_ws);
  RETURN_IF_ERROR(SettleMethod(scene, pose, ReceiverCount(plain), &plain));
  return result;
}

std::string ContentKey(const std::string& scene_name, const ValidatedRender& render, const std::string& version,
                       const std::string& gl_renderer) {
  Sha256 sha;
  const auto add_text = [&sha](const std::string& text) {
    const uint64_t size = text.size();
    sha.Add(&size, sizeof(size));
    sha.Add(text.data(), text.size());
  };
  const auto add = [&sha](auto... values) { (sha.Add(&values, sizeof(values)), ...); };
  const auto add_dvec3 = [&add](const glm::dvec3& v) { add(v.x, v.y, v.z); };
  const auto add_vec3 = [&add](const glm::vec3& v) { add(v.x, v.y, v.z); };
  const RenderRequest& request = render.request;
  add_text("halfshade content key 1");
  add_text(scene_name);
  add_text(version);
  add_text(gl_renderer);
  add(request.scene_index, request.width, request.height, request.samples, request.seed);
  add(request.node_overrides.size());
  for (const NodeOverride& change : request.node_overrides) {
    add(change.node, change.is_visible, change.casts, change.receives, change.local.has_value());
    if (change.local) add(*change.local);
  }
  for (const float weight : render.morph_weights) add(weight);
  const Camera& camera = request.camera;
  for (const glm::dvec3& v : {camera.eye_ws, camera.right_ws, camera.up_ws, camera.forward_ws, camera.target_ws}) {
    add_dvec3(v);
  }
  add(camera.is_orthographic, camera.tan_half_fovy, camera.ortho_height_m, camera.near_m, camera.far_m);
  add(request.lights.size());
  for (const AreaLight& light : request.lights) {
    for (const glm::dvec3& v : {light.center_ws, light.axis_u_ws, light.axis_v_ws, light.normal_ws}) add_dvec3(v);
    add(light.width_m, light.height_m, light.is_two_sided);
    add_vec3(light.radiance);
    add_vec3(light.intensity);
  }
  add(request.ground.has_value());
  if (request.ground) add(request.ground->height_m, request.ground->size_m, request.ground->is_shadow_catcher);
  add(request.fog.has_value());
  if (request.fog) {
    add(request.fog->density_per_m, request.fog->falloff_height_m, request.fog->ground_m);
    add_vec3(request.fog->albedo);
  }
  add(request.budget.max_error.value_or(0));  // a picture that broke it is drawn again
  add(request.method.index());
  if (const auto* hard = std::get_if<HardOptions>(&request.method)) add(hard->map_size);
  if (const auto* multi_map = std::get_if<MultiMapOptions>(&request.method)) add(multi_map->k, multi_map->map_size);
  if (const auto* ray = std::get_if<RayOptions>(&request.method)) {
    add(ray->rays, ray->is_adaptive, ray->stop_error, ray->max_error, ray->is_filtered);
  }
  if (const auto* pcss = std::get_if<PcssOptions>(&request.method)) {
    add(pcss->map_size, pcss->blocker_taps, pcss->filter_taps, pcss->weights, pcss->skips);
  }
  if (const auto* ssm = std::get_if<SsmOptions>(&request.method)) {
    add(ssm->occluder_map_size, ssm->passes, ssm->sub_lights, ssm->bins, ssm->measures_coverage, ssm->accumulation,
        ssm->blend, ssm->projects_map);
  }
  if (const auto* pdsm = std::get_if<PdsmOptions>(&request.method)) {
    add(pdsm->k, pdsm->map_size, pdsm->pdsm_size, pdsm->eps, pdsm->construction, pdsm->layout, pdsm->filter,
        pdsm->has_soft_events, pdsm->is_surface_only);
  }
  if (const auto* sssm = std::get_if<SssmOptions>(&request.method)) {
    add(sssm->map_size, sssm->blocker_taps, sssm->filter_taps, sssm->weights, sssm->skips, sssm->alpha, sssm->beta,
        sssm->thresholds, sssm->sub_lights);
  }
  if (const auto* shaft = std::get_if<ShaftOptions>(&request.method)) {
    add(shaft->rows, shaft->is_sparse, shaft->max_error, shaft->most_polygons);
  }
  add_vec3(request.shading.ambient);
  add_vec3(request.shading.background);
  add(request.shading.exposure_ev, request.shading.tone_map);
  add(request.outputs.size());
  for (size_t i = 0; i < request.outputs.size(); ++i) {
    add(request.outputs[i], render.formats[i].encoding, render.formats[i].channels.size());
    if (request.outputs[i] == OutputKind::kSoftShadowMap) add(request.light_map_size);
    add_text(render.formats[i].layer);
  }
  return sha.FinishHex();
}

}  // namespace halfshade
