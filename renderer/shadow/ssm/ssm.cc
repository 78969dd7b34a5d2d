#include "renderer/shadow/ssm/ssm.h"

#include <glad/gl.h>

#include <algorithm>
#include <span>

#include "renderer/light/binned_map.h"
#include "renderer/light/parallel_for.h"
#include "renderer/light/receiver_tile.h"
#include "renderer/light/sub_lights.h"
#include "renderer/shadow/ssm/choose.h"
#include "renderer/shadow/ssm/gather.h"
#include "renderer/shadow/ssm/gather_on_gl.h"
#include "renderer/shadow/ssm/projected_map.h"
#include "renderer/shadow/ssm/scatter.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// The occluder maps of one sub-light: nearest surfaces, and furthest where there are two passes.
using Layers = std::vector<BinnedMap>;
using LayersOnGl = std::vector<BinnedMapOnGl>;

struct SsmData : LightData {
  AreaLight light;
  SsmChoice choice;
  int passes = 1;
  SubLights cells;
  BinnedMapOptions map_options;
  bool is_on_cpu = true;
  // The soft shadow map, if receivers look their visibility up in it: all that is kept then.
  ProjectedMap projected;
  double largest_fraction = 0;  // of the map's, before it was clamped
  std::string note;
  // Of the first cells; the others' are drawn at every resolve. One of the two is empty.
  std::vector<Layers> maps;
  std::vector<LayersOnGl> maps_on_gl;
  std::shared_ptr<const OccludersOnContext> occluders;  // null where all are kept

  uint64_t SizeBytes() const override {
    uint64_t bytes = projected.texels.SizeBytes() + (occluders == nullptr ? 0 : occluders->SizeBytes());
    for (const Layers& layers : maps) {
      for (const BinnedMap& map : layers) bytes += map.SizeBytes();
    }
    for (const LayersOnGl& layers : maps_on_gl) {
      for (const BinnedMapOnGl& map : layers) bytes += map.SizeBytes();
    }
    return bytes;
  }
  size_t CellsKept() const { return maps.size() + maps_on_gl.size(); }
  // Of a projected map all were drawn for it, and none is any more.
  uint64_t MapsDrawn() const override { return (projected.texels ? cells.centers.size() : CellsKept()) * passes; }
  uint64_t MapsRedrawn() const override { return cells.centers.size() * passes - MapsDrawn(); }
  std::vector<std::pair<std::string, std::string>> ChosenOptions() const override {
    return {{"occluder_map_size", std::to_string(choice.map_size)}, {"sub_lights", std::to_string(choice.sub_lights)}};
  }
};

uint64_t BytesOfMap(const BinnedMapOptions& options) {
  const uint64_t side = uint64_t(options.size) * options.texels_per_patch;
  return 4 * (side * side + BinnedMap::kPadding) + DepthTables::SizeBytes(options.size, options.slabs);
}

absl::StatusOr<Layers> DrawLayers(const DrawContext& draw, const SsmData& data,
                                  const std::shared_ptr<const OccludersOnContext>& occluders, size_t cell) {
  Layers layers;
  for (int pass = 0; pass < data.passes; ++pass) {
    BinnedMapOptions options = data.map_options;
    options.layer = pass == 0 ? OccluderLayer::kNearest : OccluderLayer::kFurthest;
    ASSIGN_OR_RETURN(BinnedMap map, DrawBinnedMap(draw, occluders, data.light, data.cells.centers[cell], options));
    layers.push_back(std::move(map));
  }
  return layers;
}

absl::StatusOr<LayersOnGl> Upload(const gl::Context& context, Layers layers) {
  LayersOnGl on_gl;
  for (BinnedMap& map : layers) {
    ASSIGN_OR_RETURN(on_gl.emplace_back(), UploadBinnedMap(context, std::move(map)));
  }
  return on_gl;
}

// One a receiver: 1 where the point that the map is drawn from is hidden, by maps of all sides. Empty where the map
// holds all occluders.
absl::StatusOr<std::vector<float>> FindHiddenPoint(const DrawContext& draw, const BinnedMap& map,
                                                   const Receivers& receivers) {
  std::vector<float> hidden;
  if (map.all_sides == nullptr) return hidden;
  ASSIGN_OR_RETURN(const gl::Texture counts, map.all_sides->CountHidden(draw, receivers));
  hidden.resize(size_t(receivers.width) * receivers.height);
  std::vector<float> pairs(2 * hidden.size());
  RETURN_IF_ERROR(counts.ReadFloats(pairs.data(), pairs.size()));
  // Of a point below the receiver's plane nothing is counted: the part of the sub-light that is above is lit. (Dark
  // would be worse: .0299 for .0287 in a garage, .0026 for .0007 in the stress suite's random scenes.)
  for (size_t i = 0; i < hidden.size(); ++i) hidden[i] = pairs[2 * i];
  return hidden;
}

// Adds what `maps` hide to `hidden`, and their shares to `share`.
absl::Status Gather(const DrawContext& draw, const SsmData& data, std::span<const Layers> maps,
                    const Receivers& receivers, std::vector<float>* hidden, std::vector<float>* share) {
  std::vector<std::vector<float>> hidden_points;
  for (const Layers& layers : maps) {
    ASSIGN_OR_RETURN(hidden_points.emplace_back(), FindHiddenPoint(draw, layers[0], receivers));
  }
  const ReceiverTiles tiles(*receivers.on_cpu, data.light);
  const glm::vec2 half_edges(data.cells.half_edges);
  const auto gather_tile = [&](int index) {
    ReceiverTile tile;
    tiles.Fill(index, &tile);
    for (size_t m = 0; m < maps.size() && tile.count > 0; ++m) {
      const float* hidden_point = hidden_points[m].empty() ? nullptr : hidden_points[m].data();
      GatherTile(maps[m], half_edges, tile, hidden_point, hidden->data(), share->data());
    }
  };
  return ParallelFor(tiles.count(), 1, gather_tile, [&draw] { return draw.pacer->Finish(); });
}

absl::StatusOr<OcclusionSum> ResolveOnCpu(const DrawContext& draw, const SsmData& data, const Receivers& receivers) {
  std::vector<float> hidden(receivers.on_cpu->size());
  std::vector<float> share(hidden.size());
  RETURN_IF_ERROR(Gather(draw, data, data.maps, receivers, &hidden, &share));
  for (size_t cell = data.CellsKept(); cell < data.cells.centers.size(); ++cell) {
    ASSIGN_OR_RETURN(const Layers layers, DrawLayers(draw, data, data.occluders, cell));
    RETURN_IF_ERROR(Gather(draw, data, {&layers, 1}, receivers, &hidden, &share));
  }
  for (size_t i = 0; i < hidden.size(); ++i) hidden[i] = share[i] > 0 ? hidden[i] / share[i] : 0;
  return OcclusionSum{std::move(hidden), 1, 0};
}

absl::StatusOr<OcclusionSum> ResolveOnGl(const DrawContext& draw, const SsmData& data, const Receivers& receivers) {
  ASSIGN_OR_RETURN(gl::Texture sums, gl::Texture::Create2D(*draw.context, GL_RG32F, receivers.width, receivers.height));
  const float zeros[4] = {};
  draw.context->gl().ClearTexImage(sums.id(), 0, GL_RG, GL_FLOAT, zeros);
  for (size_t cell = 0; cell < data.cells.centers.size(); ++cell) {
    LayersOnGl drawn;
    if (cell >= data.CellsKept()) {
      ASSIGN_OR_RETURN(Layers layers, DrawLayers(draw, data, data.occluders, cell));
      ASSIGN_OR_RETURN(drawn, Upload(*draw.context, std::move(layers)));
    }
    const LayersOnGl& layers = drawn.empty() ? data.maps_on_gl[cell] : drawn;
    RETURN_IF_ERROR(GatherOnGl(draw, layers, data.cells.half_edges, data.light, receivers, sums));
  }
  return OcclusionSum{std::move(sums), 0, 0};
}

absl::StatusOr<OcclusionSum> Gather(const DrawContext& draw, const SsmData& data, const Receivers& receivers) {
  return data.is_on_cpu ? ResolveOnCpu(draw, data, receivers) : ResolveOnGl(draw, data, receivers);
}

// Hidden fractions of the receivers of a soft shadow map, gathered.
absl::StatusOr<std::vector<float>> GatherMap(const DrawContext& draw, const SsmData& data,
                                             const ReceiverMap& receiver_map) {
  Receivers receivers = receiver_map.receivers;
  CpuReceivers on_cpu;
  if (data.is_on_cpu) {
    ASSIGN_OR_RETURN(on_cpu, ReadBackReceivers(receivers));
    receivers.on_cpu = &on_cpu;
  }
  ASSIGN_OR_RETURN(OcclusionSum sum, Gather(draw, data, receivers));
  if (data.is_on_cpu) return std::get<std::vector<float>>(std::move(sum.sums));
  std::vector<float> hidden(receiver_map.light_z.size());
  std::vector<float> pairs(2 * hidden.size());
  RETURN_IF_ERROR(std::get<gl::Texture>(sum.sums).ReadFloats(pairs.data(), pairs.size()));
  for (size_t i = 0; i < hidden.size(); ++i) hidden[i] = pairs[2 * i + 1] > 0 ? pairs[2 * i] / pairs[2 * i + 1] : 0;
  return hidden;
}

// The same, by patches that are blended into the map; and what sums were like.
absl::StatusOr<std::vector<float>> ScatterMap(const DrawContext& draw, const ReceiverMap& receiver_map, SsmBlend blend,
                                              SsmData* data) {
  ASSIGN_OR_RETURN(const ScatterReceivers receivers, MakeScatterReceivers(*draw.context, receiver_map));
  std::vector<float> hidden(receiver_map.light_z.size());
  const auto cells = float(data->cells.centers.size());
  double least_width = 1;
  uint64_t patches = 0;
  for (size_t cell = 0; cell < data->cells.centers.size(); ++cell) {
    ASSIGN_OR_RETURN(const Layers layers, DrawLayers(draw, *data, data->occluders, cell));
    std::vector<float> most(hidden.size());  // of the layers
    for (const BinnedMap& layer : layers) {
      ASSIGN_OR_RETURN(const ScatterSums sums, Scatter(draw, layer, data->cells.half_edges, receivers, blend));
      least_width = std::min(least_width, sums.least_width);
      patches += sums.patches;
      for (size_t i = 0; i < most.size(); ++i) {
        most[i] = std::max(most[i], sums.hidden[i]);
        data->largest_fraction = std::max(data->largest_fraction, double(sums.hidden[i]));
      }
    }
    ASSIGN_OR_RETURN(const std::vector<float> hidden_point, FindHiddenPoint(draw, layers[0], receiver_map.receivers));
    for (size_t i = 0; i < hidden.size(); ++i) {
      const bool leaves_map = !hidden_point.empty() && receivers.LeavesMap(i, layers[0], data->cells.half_edges);
      hidden[i] += (leaves_map ? hidden_point[i] : std::min(most[i], 1.0f)) / cells;
    }
  }
  const double needed = blend == SsmBlend::kFp32 ? kLeastWidthFp32 : kLeastWidthFp16;
  data->note = std::to_string(patches) + " patches; one hides 1/" + std::to_string(std::lround(1 / least_width)) +
               " of the light's width or more, eq. 4 wants 1/" + std::to_string(std::lround(1 / needed));
  return hidden;
}

}  // namespace

MethodNeeds SsmMethod::Needs(const MethodOptions& options, const SceneFacts& facts) const {
  const auto& ssm = std::get<SsmOptions>(options);
  const int q = std::max(ssm.sub_lights, 1);
  return {.maps = uint32_t(q * q * ssm.passes),
          .map_size = ssm.occluder_map_size,
          .cpu_receivers = IsOnCpu(facts.is_software_gl) && !ssm.projects_map,
          .receiver_map = ssm.projects_map};
}

absl::StatusOr<std::unique_ptr<LightData>> SsmMethod::BuildLightData(const DrawContext& draw, const LightInputs& inputs,
                                                                     const MethodOptions& options) const {
  const auto& ssm = std::get<SsmOptions>(options);
  auto data = std::make_unique<SsmData>();
  data->light = inputs.light;
  data->is_on_cpu = IsOnCpu(draw.context->IsSoftware());
  data->choice = ChooseSsm(ssm, inputs.light, inputs.occluders->hull());
  data->passes = ssm.passes;
  data->cells = MakeSubLights(inputs.light, data->choice.sub_lights);
  const bool scatters = ssm.accumulation == SsmAccumulation::kScatter;
  data->map_options = {.size = data->choice.map_size,
                       .texels_per_patch = ssm.measures_coverage ? 2 : 1,
                       .slabs = scatters ? 0 : ssm.bins};
  if (ssm.projects_map) {
    data->occluders = inputs.occluders;
    const ReceiverMap& receivers = *inputs.receiver_map;
    ASSIGN_OR_RETURN(const std::vector<float> hidden,
                     scatters ? ScatterMap(draw, receivers, ssm.blend, data.get()) : GatherMap(draw, *data, receivers));
    data->occluders = nullptr;
    ASSIGN_OR_RETURN(data->projected, MakeProjectedMap(*draw.context, receivers, hidden));
    return data;
  }
  const uint64_t cell_bytes = BytesOfMap(data->map_options) * data->passes;
  uint64_t kept = data->cells.centers.size();
  if (cell_bytes * kept > inputs.max_light_data_bytes) {
    data->occluders = inputs.occluders;
    const uint64_t left =
        inputs.max_light_data_bytes - std::min(inputs.max_light_data_bytes, data->occluders->SizeBytes());
    kept = std::min(kept - 1, left / cell_bytes);
  }
  for (size_t cell = 0; cell < kept; ++cell) {
    ASSIGN_OR_RETURN(Layers layers, DrawLayers(draw, *data, inputs.occluders, cell));
    if (data->is_on_cpu) {
      data->maps.push_back(std::move(layers));
    } else {
      ASSIGN_OR_RETURN(data->maps_on_gl.emplace_back(), Upload(*draw.context, std::move(layers)));
    }
  }
  return data;
}

absl::StatusOr<OcclusionSum> SsmMethod::ResolveOcclusion(const DrawContext& draw, const LightData& light_data,
                                                         const Receivers& receivers, const MethodOptions&) const {
  const auto& data = static_cast<const SsmData&>(light_data);
  if (!data.projected.texels) return Gather(draw, data, receivers);
  ASSIGN_OR_RETURN(gl::Texture hidden, Project(draw, data.projected, data.light, receivers));
  return OcclusionSum{.sums = std::move(hidden), .note = data.note, .largest_fraction = data.largest_fraction};
}

std::vector<std::pair<std::string, std::string>> SsmMethod::DescribeOptions(const MethodOptions& options) const {
  const auto& ssm = std::get<SsmOptions>(options);
  const auto chosen = [](int value) { return value == 0 ? std::string(kChosen) : std::to_string(value); };
  const bool scatters = ssm.accumulation == SsmAccumulation::kScatter;
  constexpr const char* kBlends[] = {"FP32", "FP16", "FP16_BATCHED"};
  std::vector<std::pair<std::string, std::string>> described = {{"occluder_map_size", chosen(ssm.occluder_map_size)},
                                                                {"resolve", ssm.projects_map ? "MAP" : "PIXELS"},
                                                                {"passes", std::to_string(ssm.passes)},
                                                                {"accumulation", scatters ? "SCATTER" : "BINNED"},
                                                                {"sub_lights", chosen(ssm.sub_lights)},
                                                                {"coverage", ssm.measures_coverage ? "true" : "false"}};
  if (scatters) {
    described.emplace_back("blend", kBlends[int(ssm.blend)]);
  } else {
    described.emplace_back("bins", std::to_string(ssm.bins));
  }
  return described;
}

}  // namespace halfshade
