// RAY: rays to scrambled Sobol points of the light (renderer/light/trace_light.h), on the CPU. The reference that every
// other method is measured against, and with adaptive rays a rival of its own.
#pragma once

#include "renderer/shadow/shadow_method.h"

namespace halfshade {

class RayMethod : public ShadowMethod {
 public:
  MethodNeeds Needs(const MethodOptions& options, const SceneFacts& facts) const override;
  absl::StatusOr<std::unique_ptr<LightData>> BuildLightData(const DrawContext& draw, const LightInputs& inputs,
                                                            const MethodOptions& options) const override;
  // Reads Receivers::on_cpu; sums in memory.
  absl::StatusOr<OcclusionSum> ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                const Receivers& receivers,
                                                const MethodOptions& options) const override;
  std::string LightDataOptions(const MethodOptions&) const override { return ""; }
  std::vector<std::pair<std::string, std::string>> DescribeOptions(const MethodOptions& options) const override;
};

}  // namespace halfshade
