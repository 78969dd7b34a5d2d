// PCSS: one map from the light's centre, filtered over the light's image at the average depth of the blockers
// (renderer/light/center_map). A rival: quick, and wrong wherever one average depth or one view does not tell the
// whole.
//
// Departures from Fernando 2005, "Percentage-Closer Soft Shadows", each to its advantage: windows are exact in light
// perspective space; a blocker counts only where it can hide part of the light; the bias is the project's rule, not a
// constant; tiles that a min/max pyramid decides are not drawn, to the same bits.
#pragma once

#include "renderer/shadow/shadow_method.h"

namespace halfshade {

class PcssMethod : public ShadowMethod {
 public:
  MethodNeeds Needs(const MethodOptions& options, const SceneFacts& facts) const override;
  absl::StatusOr<std::unique_ptr<LightData>> BuildLightData(const DrawContext& draw, const LightInputs& inputs,
                                                            const MethodOptions& options) const override;
  std::string LightDataOptions(const MethodOptions& options) const override;  // the map's size alone
  absl::StatusOr<OcclusionSum> ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                const Receivers& receivers,
                                                const MethodOptions& options) const override;
  bool KnowsBlockers() const override { return true; }
  std::vector<std::pair<std::string, std::string>> DescribeOptions(const MethodOptions& options) const override;
};

}  // namespace halfshade
