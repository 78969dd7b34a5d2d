// SSSM: PCSS whose two windows are rows and columns: each pixel sums the blockers of its own row of the map and blurs
// its own row, and takes the rows above and below from the pixels that stand there. README.md has the steps.
//
// Source: Buades, Gumbau, Chover 2015, "Separable soft shadow mapping".
#pragma once

#include "renderer/shadow/shadow_method.h"

namespace halfshade {

class SssmMethod : public ShadowMethod {
 public:
  MethodNeeds Needs(const MethodOptions& options, const SceneFacts& facts) const override;
  absl::StatusOr<std::unique_ptr<LightData>> BuildLightData(const DrawContext& draw, const LightInputs& inputs,
                                                            const MethodOptions& options) const override;
  std::string LightDataOptions(const MethodOptions& options) const override;  // maps and sub-lights alone
  absl::StatusOr<OcclusionSum> ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                const Receivers& receivers,
                                                const MethodOptions& options) const override;
  bool KnowsBlockers() const override { return true; }
  std::vector<std::pair<std::string, std::string>> DescribeOptions(const MethodOptions& options) const override;
};

}  // namespace halfshade
