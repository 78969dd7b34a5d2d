// Light data for one side of a light: from the context's caches, or built and kept there.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/object_cache.h"
#include "renderer/light/light_data.h"
#include "renderer/plan/frame_plan.h"
#include "renderer/renderer.h"
#include "renderer/report.h"
#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/ray_scene.h"
#include "renderer/scene/scene_on_context.h"
#include "renderer/shadow/shadow_method.h"

namespace halfshade {

// Of one context.
struct LightCaches {
  gl::ObjectCache<LightData> light_data;
  gl::ObjectCache<const RayScene> ray_scenes;
  gl::ObjectCache<const SceneData> scene_data;
  LightStore* store = nullptr;  // beyond the context; may be null
};

// What light data is made from.
struct LightSource {
  const std::string& scene_name;
  const FlatScene& scene;
  const Pose& pose;
  const RenderRequest& request;
  const RegisteredMethod& method;
  const SceneOnContext* on_context = nullptr;  // with the masks' textures; null for methods that draw no maps
  const ImageDecoder& decoder;                 // for masks of ray scenes
  uint64_t computed_lights =
      1;                     // of the call: each may take as much of the cache, so that the next call finds them all
  bool is_of_moved = false;  // its casters are those that the request moves (light_layers.h)
};

// "light[0]/", "light[0]/back/".
std::string LightName(const LightPlan& plan);

// What a method's needs depend on here.
SceneFacts FactsOf(const DrawContext& draw);

// Puts what was chosen (LightData::ChosenOptions, OcclusionSum::chosen_options) into the report in place of kChosen;
// where lights differ, the values of all.
void ReportChosen(const std::vector<std::pair<std::string, std::string>>& chosen, RenderReport& report);

// How many sides the method runs for.
uint64_t CountComputed(const std::vector<LightPlan>& lights);

// The casters as triangles to trace in: from the context's cache, or built (a pass "ray_scene" of the report) and kept.
absl::StatusOr<gl::ObjectCache<const RayScene>::Pointer> PrepareRayScene(const DrawContext& draw,
                                                                         const LightSource& source, LightCaches& caches,
                                                                         RenderReport& report);

// `pass` names its line in the report.
absl::StatusOr<gl::ObjectCache<LightData>::Pointer> PrepareLight(const DrawContext& draw, const LightSource& source,
                                                                 const AreaLight& side, const std::string& pass,
                                                                 LightCaches& caches, RenderReport& report);

}  // namespace halfshade
