#include "renderer/soft_shadow_map.h"

#include <string>

#include "renderer/passes.h"
#include "renderer/shade/data_image.h"
#include "renderer/shade/gbuffer.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// v, then light_z, of each receiver.
absl::StatusOr<Image> ReadMap(const DrawContext& draw, const gl::Texture& visibility, const GBuffer& gbuffer,
                              const RenderRequest& view, const std::string& method) {
  Image map(view.width, view.height, 2);
  RETURN_IF_ERROR(visibility.ReadFloats(map.data(), map.size()));
  ASSIGN_OR_RETURN(const Image depth, ReadDataImage(draw, OutputKind::kDepth, gbuffer, view.camera));
  for (size_t i = 0; i < depth.size(); ++i) {
    const float v = map.data()[2 * i];
    if (!(v >= 0 && v <= 1)) {
      return absl::InternalError(method + ": visibility " + std::to_string(v) + " in the soft shadow map");
    }
    map.data()[2 * i + 1] = depth.data()[i];
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
  const Pose receiving = GridReceivers(source.pose, source.request);
  SoftShadowMap map;
  map.grid = PlanLightGrid(source.scene, source.pose, receiving, source.request, plan.light);
  RenderRequest view = source.request;
  view.camera = CameraOf(map.grid, plan.light, source.request);
  view.width = view.height = source.request.light_map_size;
  GBuffer gbuffer;
  RETURN_IF_ERROR(TimedPass(draw, report, name + "receiver_map", &report.shade_ms, [&]() -> absl::Status {
    ASSIGN_OR_RETURN(gbuffer, DrawGBuffer(draw, source.scene, *source.on_context, receiving, view, {}));
    report.passes.back().count = gbuffer.triangles_drawn;
    return absl::OkStatus();
  }));
  if (computes && layers.empty()) {
    ASSIGN_OR_RETURN(layers, PrepareLayers(draw, source, apart, plan.light, name + "light_data", caches, report));
  }
  Receivers receivers = {&gbuffer.planes, view.camera, view.width, view.height};
  CpuReceivers on_cpu;
  RETURN_IF_ERROR(TimedPass(draw, report, name + "soft_shadow_map", &report.resolve_ms, [&]() -> absl::Status {
    if (!layers.empty() && NeedCpuReceivers(draw, source.request, apart)) {
      ASSIGN_OR_RETURN(on_cpu, ReadBackReceivers(receivers));
      receivers.on_cpu = &on_cpu;
    }
    ASSIGN_OR_RETURN(const ResolvedSide resolved, ResolveSide(draw, layers, receivers, plan.light));
    report.passes.back().count = resolved.occlusion.count;
    report.passes.back().reason = resolved.occlusion.note;
    ASSIGN_OR_RETURN(map.image, ReadMap(draw, resolved.visibility, gbuffer, view, source.method.name));
    return absl::OkStatus();
  }));
  return map;
}

}  // namespace halfshade
