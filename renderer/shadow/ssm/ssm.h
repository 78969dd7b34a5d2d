// SSM: soft shadow maps. Each texel of an occluder map is a patch, parallel to the light, of which a receiver sees an
// image on the light; hidden fractions of the light are summed over patches.
//
// Source: Atty, Holzschuch, Lapierre, Hasenfratz, Hansen, Sillion 2006, "Soft Shadow Maps: Efficient Sampling of Light
// Source Visibility". Departures, reasons and costs: README.md of this folder.
#pragma once

#include "renderer/shadow/shadow_method.h"

namespace halfshade {

// Where the receivers are gathered at.
enum class SsmProcessor : uint8_t {
  kAuto,  // the CPU where GL is software
  kCpu,
  kGl,
};

class SsmMethod : public ShadowMethod {
 public:
  explicit SsmMethod(SsmProcessor processor = SsmProcessor::kAuto) : processor_(processor) {}
  MethodNeeds Needs(const MethodOptions& options, const SceneFacts& facts) const override;
  absl::StatusOr<std::unique_ptr<LightData>> BuildLightData(const DrawContext& draw, const LightInputs& inputs,
                                                            const MethodOptions& options) const override;
  absl::StatusOr<OcclusionSum> ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                const Receivers& receivers,
                                                const MethodOptions& options) const override;
  std::vector<std::pair<std::string, std::string>> DescribeOptions(const MethodOptions& options) const override;

 private:
  bool IsOnCpu(bool is_software_gl) const {
    return processor_ == SsmProcessor::kAuto ? is_software_gl : processor_ == SsmProcessor::kCpu;
  }
  SsmProcessor processor_;
};

}  // namespace halfshade
