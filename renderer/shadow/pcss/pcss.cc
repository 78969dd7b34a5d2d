#include "renderer/shadow/pcss/pcss.h"

#include "renderer/light/center_map.h"
#include "renderer/status.h"

namespace halfshade {

MethodNeeds PcssMethod::Needs(const MethodOptions& options, const SceneFacts&) const {
  const int map_size = std::get<PcssOptions>(options).map_size;
  return {.maps = 1, .map_size = map_size, .light_data_bytes = CenterMap::PredictedBytes(map_size)};
}

absl::StatusOr<std::unique_ptr<LightData>> PcssMethod::BuildLightData(const DrawContext& draw,
                                                                      const LightInputs& inputs,
                                                                      const MethodOptions& options) const {
  return CenterMap::Create(draw, inputs.occluders, inputs.light, inputs.light, std::get<PcssOptions>(options).map_size);
}

std::string PcssMethod::LightDataOptions(const MethodOptions& options) const {
  return "map_size=" + std::to_string(std::get<PcssOptions>(options).map_size);
}

absl::StatusOr<OcclusionSum> PcssMethod::ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                          const Receivers& receivers,
                                                          const MethodOptions& options) const {
  const auto& pcss = std::get<PcssOptions>(options);
  ASSIGN_OR_RETURN(CenterMap::Filtered filtered,
                   static_cast<const CenterMap&>(data).Filter(
                       draw, receivers, {pcss.blocker_taps, pcss.filter_taps, pcss.weights}, pcss.skips));
  OcclusionSum result;
  result.sums = std::move(filtered.hidden);
  result.blockers = std::move(filtered.blockers);
  result.count = filtered.tiles_drawn;
  return result;
}

std::vector<std::pair<std::string, std::string>> PcssMethod::DescribeOptions(const MethodOptions& options) const {
  const auto& pcss = std::get<PcssOptions>(options);
  return {{"map_size", std::to_string(pcss.map_size)},
          {"blocker_taps", std::to_string(pcss.blocker_taps)},
          {"filter_taps", std::to_string(pcss.filter_taps)},
          {"weights", WeightsName(pcss.weights)},
          {"skip", pcss.skips ? "true" : "false"}};
}

}  // namespace halfshade
