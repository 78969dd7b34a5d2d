#include "renderer/shadow/hard/hard.h"

#include "renderer/light/sample_maps.h"
#include "renderer/status.h"

namespace halfshade {

MethodNeeds HardMethod::Needs(const MethodOptions& options, const SceneFacts&) const {
  const auto& hard = std::get<HardOptions>(options);
  return {.maps = 1, .map_size = hard.map_size, .light_data_bytes = 4ull * hard.map_size * hard.map_size};
}

absl::StatusOr<std::unique_ptr<LightData>> HardMethod::BuildLightData(const DrawContext& draw,
                                                                      const LightInputs& inputs,
                                                                      const MethodOptions& options) const {
  return SampleMaps::Create(draw, inputs.occluders, inputs.light, {glm::dvec2(0)},
                            std::get<HardOptions>(options).map_size, inputs.max_light_data_bytes);
}

absl::StatusOr<OcclusionSum> HardMethod::ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                          const Receivers& receivers, const MethodOptions&) const {
  OcclusionSum result;
  ASSIGN_OR_RETURN(result.sums, static_cast<const SampleMaps&>(data).CountHidden(draw, receivers));
  result.full_sum = 0;
  return result;
}

std::vector<std::pair<std::string, std::string>> HardMethod::DescribeOptions(const MethodOptions& options) const {
  return {{"map_size", std::to_string(std::get<HardOptions>(options).map_size)}};
}

}  // namespace halfshade
