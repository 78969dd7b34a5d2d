#include "renderer/shadow/ray/ray.h"

#include <charconv>

#include "renderer/light/trace_light.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// The hierarchy is the scene's, and counted here too, since this keeps it; of the light there is nothing to prepare.
struct RayLightData : LightData {
  std::shared_ptr<const RayScene> scene;
  AreaLight light;
  uint32_t seed = 0;
  uint64_t SizeBytes() const override { return scene->SizeBytes(); }
  uint64_t MapsDrawn() const override { return 0; }
};

// Shortest form that reads back.
std::string NumberText(float value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof(text), value).ptr);
}

}  // namespace

MethodNeeds RayMethod::Needs(const MethodOptions&, const SceneFacts&) const {
  return {.ray_scene = true, .cpu_receivers = true};
}

absl::StatusOr<std::unique_ptr<LightData>> RayMethod::BuildLightData(const DrawContext&, const LightInputs& inputs,
                                                                     const MethodOptions&) const {
  auto data = std::make_unique<RayLightData>();
  data->scene = inputs.ray_scene;
  data->light = inputs.light;
  data->seed = inputs.seed;
  return data;
}

absl::StatusOr<OcclusionSum> RayMethod::ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                         const Receivers& receivers,
                                                         const MethodOptions& options) const {
  const auto& ray_data = static_cast<const RayLightData&>(data);
  const auto& ray = std::get<RayOptions>(options);
  const TraceOptions trace = {
      .rays = ray.rays, .is_adaptive = ray.is_adaptive, .stop_error = ray.stop_error, .seed = ray_data.seed};
  ASSIGN_OR_RETURN(TracedLight traced, TraceLight(*ray_data.scene, ray_data.light, *receivers.on_cpu, trace,
                                                  [&draw] { return draw.pacer->Finish(); }));
  OcclusionSum sum{std::move(traced.hidden), 1, traced.rays};
  sum.errors = std::move(traced.errors);
  if (traced.lit > 0)
    sum.note = std::to_string(traced.lit) + " receivers lit: nothing between their tiles and the light";
  sum.has_independent_errors = true;
  return sum;
}

std::vector<std::pair<std::string, std::string>> RayMethod::DescribeOptions(const MethodOptions& options) const {
  const auto& ray = std::get<RayOptions>(options);
  return {{"rays", std::to_string(ray.rays)},
          {"adaptive", ray.is_adaptive ? "true" : "false"},
          {"stop_error", NumberText(ray.stop_error)}};
}

}  // namespace halfshade
