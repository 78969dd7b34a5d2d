#include "renderer/shadow/ray/ray.h"

#include <algorithm>
#include <charconv>

#include "renderer/light/trace_filtered.h"
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

// What neighbours lend a filtered pixel (trace_filtered.h), a point has to trace itself.
constexpr int kRaysOfPoint = 16;
constexpr int kMostRays = 65536;

std::string NoteOf(uint64_t lit) {
  if (lit == 0) return {};
  return std::to_string(lit) + " receivers lit: nothing between their tiles and the light";
}

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
  const CpuReceivers& on_cpu = *receivers.on_cpu;
  const auto stop = [&draw] { return draw.pacer->Finish(); };
  const bool is_point = ray_data.light.width_m == 0 && ray_data.light.height_m == 0;
  if (ray.is_filtered && !is_point && !on_cpu.ArePoints()) {
    ASSIGN_OR_RETURN(FilteredLight traced, TraceFiltered(*ray_data.scene, ray_data.light, on_cpu,
                                                         {.rays = ray.rays, .seed = ray_data.seed}, stop));
    OcclusionSum sum{std::move(traced.hidden), 1, traced.rays, NoteOf(traced.lit)};
    sum.errors = std::move(traced.errors);
    return sum;
  }
  const TraceOptions trace = {.rays = ray.is_filtered ? std::min(kMostRays, kRaysOfPoint * ray.rays) : ray.rays,
                              .is_adaptive = ray.is_adaptive,
                              .stop_error = ray.stop_error,
                              .mean_error = ray.max_error,
                              .seed = ray_data.seed};
  ASSIGN_OR_RETURN(TracedLight traced, TraceLight(*ray_data.scene, ray_data.light, on_cpu, trace, stop));
  OcclusionSum sum{std::move(traced.hidden), 1, traced.rays, NoteOf(traced.lit)};
  sum.errors = std::move(traced.errors);
  sum.has_independent_errors = true;
  if (ray.max_error > 0) sum.chosen_options = {{"rays", std::to_string(traced.most_rays)}};
  return sum;
}

std::vector<std::pair<std::string, std::string>> RayMethod::DescribeOptions(const MethodOptions& options) const {
  const auto& ray = std::get<RayOptions>(options);
  return {{"rays", ray.max_error > 0 ? kChosen : std::to_string(ray.rays)},
          {"adaptive", ray.is_adaptive ? "true" : "false"},
          {"stop_error", ray.max_error > 0 ? kChosen : NumberText(ray.stop_error)},
          {"filtered", ray.is_filtered ? "true" : "false"}};
}

}  // namespace halfshade
