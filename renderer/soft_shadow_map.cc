#include "renderer/soft_shadow_map.h"

#include <string>

#include "renderer/light_view.h"
#include "renderer/passes.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// v, then light_z, of each receiver.
absl::StatusOr<Image> ReadMap(const gl::Texture& visibility, const LightView& view, const std::string& method) {
  Image map(view.request.width, view.request.height, 2);
  RETURN_IF_ERROR(visibility.ReadFloats(map.data(), map.size()));
  for (size_t i = 0; i < view.light_z.size(); ++i) {
    const float v = map.data()[2 * i];
    if (!(v >= 0 && v <= 1)) {
      return absl::InternalError(method + ": visibility " + std::to_string(v) + " in the soft shadow map");
    }
    map.data()[2 * i + 1] = view.light_z[i];
  }
  return map;
}

}  // namespace

absl::StatusOr<SoftShadowMap> DrawSoftShadowMap(const DrawContext& draw, const LightSource& source,
                                                const MovedApart* apart, const LightPlan& plan,
                                                std::vector<LightLayer> layers, LightCaches& caches,
                                                RenderReport& report) {
  const bool computes = plan.outcome == LightOutcome::kCompute;
  const std::string name = LightName(plan);
  LightView view;
  RETURN_IF_ERROR(TimedPass(draw, report, name + "receiver_map", &report.shade_ms, [&]() -> absl::Status {
    ASSIGN_OR_RETURN(view, DrawLightView(draw, source, plan.light));
    report.passes.back().count = view.gbuffer.triangles_drawn;
    return absl::OkStatus();
  }));
  if (computes && layers.empty()) {
    ASSIGN_OR_RETURN(layers, PrepareLayers(draw, source, apart, plan.light, name + "light_data", caches, report));
  }
  SoftShadowMap map;
  map.grid = view.grid;
  Receivers receivers = view.receivers();
  CpuReceivers on_cpu;
  RETURN_IF_ERROR(TimedPass(draw, report, name + "soft_shadow_map", &report.resolve_ms, [&]() -> absl::Status {
    if (!layers.empty() && NeedCpuReceivers(draw, source.request, apart)) {
      ASSIGN_OR_RETURN(on_cpu, ReadBackReceivers(receivers));
      receivers.on_cpu = &on_cpu;
    }
    ASSIGN_OR_RETURN(const ResolvedSide resolved, ResolveSide(draw, layers, receivers, plan.light));
    report.passes.back().count = resolved.occlusion.count;
    report.passes.back().reason = resolved.occlusion.note;
    ReportChosen(resolved.occlusion.chosen_options, report);
    ASSIGN_OR_RETURN(map.image, ReadMap(resolved.visibility, view, source.method.name));
    return absl::OkStatus();
  }));
  return map;
}

}  // namespace halfshade
