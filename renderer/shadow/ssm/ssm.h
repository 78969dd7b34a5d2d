// SSM: soft shadow maps. Each texel of an occluder map is a patch, parallel to the light, of which a receiver sees an
// image on the light; hidden fractions of the light are summed over patches.
//
// Source: Atty, Holzschuch, Lapierre, Hasenfratz, Hansen, Sillion 2006, "Soft Shadow Maps: Efficient Sampling of Light
// Source Visibility". Departures, reasons and costs: README.md of this folder.
#pragma once

#include "renderer/shadow/shadow_method.h"

namespace halfshade {

class SsmMethod : public ShadowMethod {
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
