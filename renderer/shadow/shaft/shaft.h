// SHAFT: for each tile of receivers the exact list of polygons between it and the light, drawn as bits of the light. On
// the CPU alone; no map, no bias, no probes: what is off is the sampling of the light.
#pragma once

#include "renderer/shadow/shadow_method.h"

namespace halfshade {

class ShaftMethod : public ShadowMethod {
 public:
  MethodNeeds Needs(const MethodOptions& options, const SceneFacts& facts) const override;
  // The shapes of dense meshes and of those with many places, their levels included.
  absl::StatusOr<std::unique_ptr<SceneData>> BuildSceneData(const DrawContext& draw,
                                                            const FlatScene& scene) const override;
  // Reads LightInputs::scene_data. RESOURCE_EXHAUSTED, with the figures, over LightInputs::light_cache_bytes.
  absl::StatusOr<std::unique_ptr<LightData>> BuildLightData(const DrawContext& draw, const LightInputs& inputs,
                                                            const MethodOptions& options) const override;
  // Reads Receivers::on_cpu; sums in memory; counts polygons drawn, of blocks of sixteen receivers.
  absl::StatusOr<OcclusionSum> ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                const Receivers& receivers,
                                                const MethodOptions& options) const override;
  std::string LightDataOptions(const MethodOptions&) const override { return ""; }
  std::vector<std::pair<std::string, std::string>> DescribeOptions(const MethodOptions& options) const override;
};

}  // namespace halfshade
