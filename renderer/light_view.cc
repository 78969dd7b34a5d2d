#include "renderer/light_view.h"

#include <utility>

#include "renderer/shade/data_image.h"
#include "renderer/status.h"

namespace halfshade {

absl::StatusOr<LightView> DrawLightView(const DrawContext& draw, const LightSource& source, const AreaLight& light) {
  const Pose receiving = GridReceivers(source.pose, source.request);
  LightView view;
  view.casts = !receiving.instances.empty() && receiving.instances[0].casts;
  view.grid = PlanLightGrid(source.scene, source.pose, receiving, source.request, light);
  view.request = source.request;
  view.request.camera = CameraOf(view.grid, light, source.request);
  view.request.width = view.request.height = source.request.light_map_size;
  ASSIGN_OR_RETURN(view.gbuffer, DrawGBuffer(draw, source.scene, *source.on_context, receiving, view.request, {}));
  ASSIGN_OR_RETURN(const Image depth, ReadDataImage(draw, OutputKind::kDepth, view.gbuffer, view.request.camera));
  view.light_z.assign(depth.data(), depth.data() + depth.size());
  return view;
}

}  // namespace halfshade
