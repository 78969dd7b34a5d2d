#include "renderer/soft_shadow_map.h"

#include <string>

#include "renderer/light_view.h"
#include "renderer/passes.h"
#include "renderer/shadow/finish_visibility.h"
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
                                                const LightPlan& plan, gl::ObjectCache<LightData>::Pointer data,
                                                LightCaches& caches, RenderReport& report) {
  const bool computes = plan.outcome == LightOutcome::kCompute;
  const std::string name = LightName(plan);
  const ShadowMethod& method = *source.method.method;
  LightView view;
  RETURN_IF_ERROR(TimedPass(draw, report, name + "receiver_map", &report.shade_ms, [&]() -> absl::Status {
    ASSIGN_OR_RETURN(view, DrawLightView(draw, source, plan.light));
    report.passes.back().count = view.gbuffer.triangles_drawn;
    return absl::OkStatus();
  }));
  if (computes && data == nullptr) {
    ASSIGN_OR_RETURN(data, PrepareLight(draw, source, plan.light, name + "light_data", caches, report));
  }
  SoftShadowMap map;
  map.grid = view.grid;
  Receivers receivers = view.receivers();
  CpuReceivers on_cpu;
  RETURN_IF_ERROR(TimedPass(draw, report, name + "soft_shadow_map", &report.resolve_ms, [&]() -> absl::Status {
    OcclusionSum occlusion;
    if (computes) {
      if (method.Needs(source.request.method, FactsOf(draw)).cpu_receivers) {
        ASSIGN_OR_RETURN(on_cpu, ReadBackReceivers(receivers));
        receivers.on_cpu = &on_cpu;
      }
      ASSIGN_OR_RETURN(occlusion, method.ResolveOcclusion(draw, *data, receivers, source.request.method));
      report.passes.back().count = data->MapsRedrawn() + occlusion.count;
      report.passes.back().reason = occlusion.note;
    }
    ASSIGN_OR_RETURN(const gl::Texture visibility,
                     FinishVisibility(draw, computes ? &occlusion : nullptr, receivers, plan.light));
    ASSIGN_OR_RETURN(map.image, ReadMap(visibility, view, source.method.name));
    return absl::OkStatus();
  }));
  return map;
}

}  // namespace halfshade
