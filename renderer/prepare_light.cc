#include "renderer/prepare_light.h"

#include <algorithm>
#include <utility>

#include "renderer/gl/turn.h"
#include "renderer/light/occluders_on_context.h"
#include "renderer/light_view.h"
#include "renderer/passes.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// What the method keeps of the scene: from the context's cache, or built (a pass "scene_data" of the report) and kept.
absl::StatusOr<gl::ObjectCache<const SceneData>::Pointer> PrepareSceneData(const DrawContext& draw,
                                                                           const LightSource& source,
                                                                           LightCaches& caches, RenderReport& report) {
  const std::string key = LightDataPrefix(source.scene_name) + "scene_data/" + source.method.name;
  gl::ObjectCache<const SceneData>::Pointer data = caches.scene_data.Find(key);
  const bool is_hit = data != nullptr;
  if (!is_hit) {
    RETURN_IF_ERROR(TimedPass(draw, report, "scene_data", &report.light_ms, [&]() -> absl::Status {
      ASSIGN_OR_RETURN(data, source.method.method->BuildSceneData(draw, source.scene));
      return absl::OkStatus();
    }));
    caches.scene_data.Keep(key, data);
  }
  report.caches.push_back(
      {.name = "scene_data", .hits = uint64_t(is_hit), .misses = uint64_t(!is_hit), .bytes = data->SizeBytes()});
  return data;
}

// From the store, or built and put there. Its pass is the report's last.
absl::Status LoadOrBuild(const DrawContext& draw, const LightSource& source, const LightInputs& inputs,
                         const std::string& key, LightStore* store, RenderReport& report,
                         gl::ObjectCache<LightData>::Pointer& data) {
  const ShadowMethod& method = *source.method.method;
  // Drivers draw their own maps.
  const std::string stored_key = key + "\n" + draw.context->renderer() + "\n" + draw.context->version();
  if (store != nullptr && source.request.cache == CacheMode::kUse) {
    const std::string bytes = store->Get(source.scene_name, stored_key);
    if (!bytes.empty()) {
      ASSIGN_OR_RETURN(data, method.LoadLightData(draw, inputs, source.request.method, bytes));
      report.passes.back().reason = data != nullptr ? "from the store" : "what the store has is not whole: built again";
    }
    if (data != nullptr) {
      report.passes.back().count = data->MapsDrawn();
      return absl::OkStatus();
    }
  }
  ASSIGN_OR_RETURN(data, method.BuildLightData(draw, inputs, source.request.method));
  report.passes.back().count = data->MapsDrawn();
  if (store == nullptr) return absl::OkStatus();
  ASSIGN_OR_RETURN(std::string bytes, method.SaveLightData(draw, *data));
  if (!bytes.empty()) store->Put(source.scene_name, stored_key, std::move(bytes));
  return absl::OkStatus();
}

}  // namespace

void ReportChosen(const std::vector<std::pair<std::string, std::string>>& chosen, RenderReport& report) {
  for (const auto& [name, value] : chosen) {
    for (auto& [reported_name, reported] : report.options) {
      if (reported_name != name) continue;
      if (reported == kChosen) {
        reported = value;
      } else if (reported != value && !reported.ends_with(", " + value)) {
        reported.append(", ").append(value);
      }
    }
  }
}

SceneFacts FactsOf(const DrawContext& draw) { return {.is_software_gl = draw.context->IsSoftware()}; }

std::string LightName(const LightPlan& plan) {
  return "light[" + std::to_string(plan.index) + (plan.is_back ? "]/back/" : "]/");
}

uint64_t CountComputed(const std::vector<LightPlan>& lights) {
  return uint64_t(std::count_if(lights.begin(), lights.end(),
                                [](const LightPlan& plan) { return plan.outcome == LightOutcome::kCompute; }));
}

absl::StatusOr<gl::ObjectCache<const RayScene>::Pointer> PrepareRayScene(const DrawContext& draw,
                                                                         const LightSource& source, LightCaches& caches,
                                                                         RenderReport& report) {
  gl::ObjectCache<const RayScene>& cache = caches.ray_scenes;
  const std::string key = CastersKey(source.scene_name, source.request);
  gl::ObjectCache<const RayScene>::Pointer ray_scene = cache.Find(key);
  const bool is_hit = ray_scene != nullptr;
  if (!is_hit) {
    RETURN_IF_ERROR(TimedPass(draw, report, "ray_scene", &report.light_ms, [&]() -> absl::Status {
      const gl::TurnPause pause;
      ASSIGN_OR_RETURN(ray_scene, RayScene::Create(source.scene, source.pose, source.decoder,
                                                   [&draw] { return draw.pacer->Ask(); }));
      report.passes.back().count = ray_scene->triangles().indices.size() / 3;
      return absl::OkStatus();
    }));
    cache.Keep(key, ray_scene);
  }
  report.caches.push_back(
      {.name = "ray_scene", .hits = uint64_t(is_hit), .misses = uint64_t(!is_hit), .bytes = ray_scene->SizeBytes()});
  return ray_scene;
}

absl::StatusOr<gl::ObjectCache<LightData>::Pointer> PrepareLight(const DrawContext& draw, const LightSource& source,
                                                                 const AreaLight& side, const std::string& pass,
                                                                 LightCaches& caches, RenderReport& report) {
  const ShadowMethod& method = *source.method.method;
  const MethodOptions& options = source.request.method;
  const MethodNeeds needs = method.Needs(options, FactsOf(draw));
  std::string key = LightDataKey(source.scene_name, source.request, side, source.method.name,
                                 (source.is_of_moved ? "of what moves: " : "") + method.LightDataOptions(options));
  if (needs.receiver_map) key += ReceiverMapKey(source.request);
  gl::ObjectCache<LightData>::Pointer data;
  if (source.request.cache == CacheMode::kUse) data = caches.light_data.Find(key);
  const bool is_hit = data != nullptr;
  if (is_hit) {
    report.passes.push_back(SkippedPass(pass, "cached"));
  } else {
    LightInputs inputs;
    inputs.light = side;
    inputs.seed = source.request.seed;
    inputs.light_cache_bytes = caches.light_data.max_bytes();
    inputs.max_light_data_bytes = inputs.light_cache_bytes / source.computed_lights;
    caches.light_data.MakeRoom(std::min(needs.light_data_bytes, inputs.max_light_data_bytes));
    if (needs.ray_scene) {
      ASSIGN_OR_RETURN(inputs.ray_scene, PrepareRayScene(draw, source, caches, report));
    }
    if (needs.scene_data) {
      ASSIGN_OR_RETURN(inputs.scene_data, PrepareSceneData(draw, source, caches, report));
      inputs.scene = &source.scene;
      inputs.pose = &source.pose;
      inputs.decoder = &source.decoder;
    }
    RETURN_IF_ERROR(TimedPass(draw, report, pass, &report.light_ms, [&]() -> absl::Status {
      if (needs.maps > 0) {
        ASSIGN_OR_RETURN(inputs.occluders,
                         OccludersOnContext::Create(draw, source.scene, *source.on_context,
                                                    BuildLightSpaceOccluders(source.scene, source.pose, side)));
      }
      LightView view;
      ReceiverMap receiver_map;
      if (needs.receiver_map) {
        ASSIGN_OR_RETURN(view, DrawLightView(draw, source, side));
        receiver_map = {view.receivers(), view.grid.window, std::move(view.light_z), view.casts};
        inputs.receiver_map = &receiver_map;
      }
      return LoadOrBuild(draw, source, inputs, key, caches.store, report, data);
    }));
    caches.light_data.Keep(key, data);
  }
  if (const uint64_t redrawn = data->MapsRedrawn(); redrawn > 0) {
    std::string& reason = report.passes.back().reason;
    reason += (reason.empty() ? "" : "; ") + std::to_string(redrawn) +
              " maps do not fit the light cache: drawn at every resolve";
  }
  ReportChosen(data->ChosenOptions(), report);
  report.caches.push_back(
      {.name = pass, .hits = uint64_t(is_hit), .misses = uint64_t(!is_hit), .bytes = data->SizeBytes()});
  return data;
}

}  // namespace halfshade
