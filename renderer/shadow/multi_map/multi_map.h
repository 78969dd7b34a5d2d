// MULTI_MAP: k shadow maps from Owen-scrambled Sobol points of the light, averaged. A true soft shadow, and the brute
// force that every ratio is taken against: error falls with k, cost is k depth passes.
#pragma once

#include "renderer/shadow/shadow_method.h"

namespace halfshade {

class MultiMapMethod : public ShadowMethod {
 public:
  MethodNeeds Needs(const MethodOptions& options, const SceneFacts& facts) const override;
  absl::StatusOr<std::unique_ptr<LightData>> BuildLightData(const DrawContext& draw, const LightInputs& inputs,
                                                            const MethodOptions& options) const override;
  absl::StatusOr<OcclusionSum> ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                const Receivers& receivers,
                                                const MethodOptions& options) const override;
  std::vector<std::pair<std::string, std::string>> DescribeOptions(const MethodOptions& options) const override;
};

}  // namespace halfshade
