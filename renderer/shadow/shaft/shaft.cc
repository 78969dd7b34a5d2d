#include "renderer/shadow/shaft/shaft.h"

#include <atomic>

#include "renderer/light/parallel_tiles.h"
#include "renderer/shadow/shaft/resolve_tile.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// The mean error is about a quarter of the mean difference of even and odd rows: each half of the samples errs by about
// 2^.75 times as much as both together, on its own.
constexpr float kErrorOfDisagreement = 0.25f;

struct ShaftLightData : LightData {
  PolygonTree tree;
  std::vector<RayMask> masks;
  AreaLight light;
  uint32_t seed = 0;
  uint64_t SizeBytes() const override {
    uint64_t bytes = tree.SizeBytes();
    for (const RayMask& mask : masks) bytes += mask.SizeBytes();
    return bytes;
  }
  uint64_t MapsDrawn() const override { return 0; }
};

}  // namespace

MethodNeeds ShaftMethod::Needs(const MethodOptions&, const SceneFacts&) const {
  return {.cpu_receivers = true, .cpu_occluders = true, .mesh_levels = true};
}

absl::StatusOr<std::unique_ptr<LightData>> ShaftMethod::BuildLightData(const DrawContext&, const LightInputs& inputs,
                                                                       const MethodOptions&) const {
  auto data = std::make_unique<ShaftLightData>();
  data->tree = BuildPolygonTree(BuildShaftPolygons(*inputs.cpu_occluders, inputs.light));
  data->masks = inputs.cpu_occluders->masks;
  data->light = inputs.light;
  data->seed = inputs.seed;
  return data;
}

absl::StatusOr<OcclusionSum> ShaftMethod::ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                           const Receivers& receivers,
                                                           const MethodOptions& options) const {
  const auto& shaft_data = static_cast<const ShaftLightData&>(data);
  const int rows = std::get<ShaftOptions>(options).rows == 0 ? 16 : std::get<ShaftOptions>(options).rows;
  const TileFiller filler(*receivers.on_cpu, shaft_data.light, shaft_data.tree.space, shaft_data.seed);
  std::vector<float> hidden(receivers.on_cpu->size(), 0);
  std::vector<float> errors(hidden.size(), 0);
  std::atomic<uint64_t> drawn = 0;
  std::atomic<int> lit = 0, resolved = 0;
  const auto resolve = [&](int index) {
    thread_local TileScratch scratch;
    thread_local Tile tile;
    thread_local TileResult result;
    if (!filler.Fill(index, &tile)) return;
    ResolveTile(shaft_data.tree, shaft_data.masks, tile, rows, &scratch, &result);
    drawn += result.drawn;
    ++(result.polygons == 0 ? lit : resolved);
    if (result.polygons == 0) return;
    for (int i = 0; i < Tile::kMost; ++i) {
      if ((tile.active[i / Tile::kLanes] >> (i % Tile::kLanes) & 1) == 0) continue;
      hidden[tile.index[i]] = result.hidden[i];
      errors[tile.index[i]] = kErrorOfDisagreement * result.disagreement[i];
    }
  };
  RETURN_IF_ERROR(ForEachTile(filler.count(), resolve, [&draw] { return draw.pacer->Finish(); }));
  const std::string note =
      std::to_string(lit) + " tiles lit: nothing in their shafts; polygons of blocks in " + std::to_string(resolved);
  return OcclusionSum{std::move(hidden), 1, drawn, note, std::move(errors)};
}

std::vector<std::pair<std::string, std::string>> ShaftMethod::DescribeOptions(const MethodOptions& options) const {
  const auto& shaft = std::get<ShaftOptions>(options);
  return {{"rows", std::to_string(shaft.rows)}, {"sparse", "false"}};
}

}  // namespace halfshade
