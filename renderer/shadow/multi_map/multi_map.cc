#include "renderer/shadow/multi_map/multi_map.h"

#include "renderer/light/sample_maps.h"
#include "renderer/light/sample_points.h"
#include "renderer/status.h"

namespace halfshade {

MethodNeeds MultiMapMethod::Needs(const MethodOptions& options, const SceneFacts&) const {
  const auto& multi_map = std::get<MultiMapOptions>(options);
  return {.maps = uint32_t(multi_map.k),
          .map_size = multi_map.map_size,
          .light_data_bytes = 4ull * multi_map.k * multi_map.map_size * multi_map.map_size};
}

absl::StatusOr<std::unique_ptr<LightData>> MultiMapMethod::BuildLightData(const DrawContext& draw,
                                                                          const LightInputs& inputs,
                                                                          const MethodOptions& options) const {
  const auto& multi_map = std::get<MultiMapOptions>(options);
  return SampleMaps::Create(draw, inputs.occluders, inputs.light,
                            SobolLightPoints(inputs.light, multi_map.k, inputs.seed), multi_map.map_size,
                            inputs.max_light_data_bytes);
}

absl::StatusOr<OcclusionSum> MultiMapMethod::ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                              const Receivers& receivers, const MethodOptions&) const {
  const auto& maps = static_cast<const SampleMaps&>(data);
  OcclusionSum result;
  ASSIGN_OR_RETURN(result.sums, maps.CountHidden(draw, receivers));
  result.full_sum = 0;
  return result;
}

std::vector<std::pair<std::string, std::string>> MultiMapMethod::DescribeOptions(const MethodOptions& options) const {
  const auto& multi_map = std::get<MultiMapOptions>(options);
  return {{"k", std::to_string(multi_map.k)}, {"map_size", std::to_string(multi_map.map_size)}};
}

}  // namespace halfshade
