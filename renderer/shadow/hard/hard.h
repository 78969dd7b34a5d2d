// HARD: one shadow map from the light's centre. Visibility is 0 or 1 (times the horizon's share).
#pragma once

#include "renderer/shadow/shadow_method.h"

namespace halfshade {

class HardMethod : public ShadowMethod {
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
