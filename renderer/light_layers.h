// What hides one side of a light, in layers whose visibilities multiply: everything together, or, for methods whose
// light data is dear (ShadowMethod::KeepsMovedApart), what stands still and what the request moves.
//
// A node that a request moves (NodeOverride::local) is, with all below it, no occluder of the still layer, whose light
// data is the same wherever it is moved to; its own shadow comes from SSM, as St-Amour et al. 2005 take it from a
// shadow map. Of a point behind both a moved and a still occluder the product says that they hide independent parts of
// the light: between max(a, b) and min(1, a + b) of what each hides, as the truth is.
#pragma once

#include <absl/status/statusor.h>

#include <optional>
#include <string>
#include <vector>

#include "renderer/prepare_light.h"
#include "renderer/shadow/shadow_method.h"

namespace halfshade {

// Requests and poses of the layers: those of the whole but for method, overrides and casters.
struct MovedApart {
  RenderRequest still_request, moved_request;
  Pose still, moved;
};
// None: the method does not ask for it, or nothing is moved. `pose` is that of the request.
absl::StatusOr<std::optional<MovedApart>> SetMovedApart(const FlatScene& scene, const Pose& pose,
                                                        const RenderRequest& request);

struct LightLayer {
  const ShadowMethod* method = nullptr;
  const MethodOptions* options = nullptr;  // of the request, or of `apart`
  gl::ObjectCache<LightData>::Pointer data;
};
// Those that have occluders. `source` is the whole; `apart`: null where SetMovedApart gave none. `pass` names their
// lines in the report.
absl::StatusOr<std::vector<LightLayer>> PrepareLayers(const DrawContext& draw, const LightSource& source,
                                                      const MovedApart* apart, const AreaLight& side,
                                                      const std::string& pass, LightCaches& caches,
                                                      RenderReport& report);

// Whether some layer reads Receivers::on_cpu, and whether some layer reads their textures.
bool NeedCpuReceivers(const DrawContext& draw, const RenderRequest& request, const MovedApart* apart);
bool NeedReceiverTextures(const DrawContext& draw, const RenderRequest& request, const MovedApart* apart);

struct ResolvedSide {
  gl::Texture visibility;      // as FinishVisibility
  gl::Texture penumbra_width;  // where Receivers::wants_blockers
  OcclusionSum occlusion;      // of the first layer; its count and note are those of all
};
// No layers: nothing hides the light.
absl::StatusOr<ResolvedSide> ResolveSide(const DrawContext& draw, const std::vector<LightLayer>& layers,
                                         const Receivers& receivers, const AreaLight& side);

}  // namespace halfshade
