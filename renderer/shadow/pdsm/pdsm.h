// PDSM: attenuation functions over the light's whole view, built once from k depth maps and looked up by any receiver.
// Source: St-Amour, Paquette, Poulin, "Soft Shadows from Extended Light Sources with Penumbra Deep Shadow Maps", GI
// 2005.
#pragma once

#include "renderer/shadow/shadow_method.h"

namespace halfshade {

class PdsmMethod : public ShadowMethod {
 public:
  MethodNeeds Needs(const MethodOptions& options, const SceneFacts& facts) const override;
  absl::StatusOr<std::unique_ptr<LightData>> BuildLightData(const DrawContext& draw, const LightInputs& inputs,
                                                            const MethodOptions& options) const override;
  std::string LightDataOptions(const MethodOptions& options) const override;
  absl::StatusOr<OcclusionSum> ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                const Receivers& receivers,
                                                const MethodOptions& options) const override;
  absl::StatusOr<std::string> SaveLightData(const DrawContext& draw, const LightData& data) const override;
  absl::StatusOr<std::unique_ptr<LightData>> LoadLightData(const DrawContext& draw, const LightInputs& inputs,
                                                           const MethodOptions& options,
                                                           const std::string& bytes) const override;
  bool KeepsMovedApart() const override { return true; }
  std::vector<std::pair<std::string, std::string>> DescribeOptions(const MethodOptions& options) const override;
};

}  // namespace halfshade
