#include "renderer/shadow/shaft/shaft.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <utility>

#include "renderer/light/cpu_occluders.h"
#include "renderer/light/parallel_for.h"
#include "renderer/light/picture_error.h"
#include "renderer/shadow/shaft/resolve_tile.h"
#include "renderer/shadow/shaft/sparse.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// The mean error is about a quarter of the mean difference of even and odd rows: each half of the samples errs by about
// 2^.75 times as much as both together, on its own.
constexpr float kErrorOfDisagreement = 0.25f;
// Where samples are coin tosses, by 2^.5 times as much: half of the difference.
constexpr float kErrorOfCoins = 0.5f;

struct ShaftSceneData : SceneData {
  explicit ShaftSceneData(MeshShapes shapes_built) : shapes(std::move(shapes_built)) {}
  MeshShapes shapes;
  uint64_t SizeBytes() const override { return shapes.SizeBytes(); }
};

struct ShaftLightData : LightData {
  std::shared_ptr<const SceneData> scene_data;  // whose shapes stand in the tree
  PolygonTree tree;
  std::vector<RayMask> masks;
  AreaLight light;
  uint32_t seed = 0;
  // With what it holds of the scene, or the bound on that would bound nothing.
  uint64_t SizeBytes() const override {
    uint64_t bytes = tree.SizeBytes() + scene_data->SizeBytes();
    for (const RayMask& mask : masks) bytes += mask.SizeBytes();
    return bytes;
  }
  uint64_t MapsDrawn() const override { return 0; }
};

// One resolve, from tile to tile.
class Resolve {
 public:
  Resolve(const ShaftLightData& data, const CpuReceivers& receivers, const ShaftOptions& options,
          std::function<absl::Status()> stop)
      : data_(data),
        receivers_(receivers),
        options_(options),
        is_sparse_(options.is_sparse && !receivers.ArePoints()),
        stop_(std::move(stop)),
        hidden_(receivers.size(), 0),
        errors_(receivers.size(), -1) {
    const auto is_blend = [](const RayMask& mask) { return mask.is_blend(); };
    if (std::any_of(data.masks.begin(), data.masks.end(), is_blend)) coin_errors_.resize(receivers.size(), 0);
  }

  absl::StatusOr<OcclusionSum> Run() {
    const TileFiller filler = MakeFiller(false);
    rows_ = options_.rows;
    if (rows_ == 0) RETURN_IF_ERROR(ChooseRows(filler));
    if (is_sparse_) {
      const TileFiller sparse_filler = MakeFiller(true);
      RETURN_IF_ERROR(ParallelFor(
          sparse_filler.count(), 1, [&](int index) { ResolveTileOf(sparse_filler, index, rows_); }, stop_));
      const SparseGrid grid(receivers_, hidden_, errors_);
      RETURN_IF_ERROR(ParallelFor(
          filler.count(), 1, [&](int index) { ResolveBetween(grid, filler, index); }, stop_));
    } else {
      RETURN_IF_ERROR(ParallelFor(
          filler.count(), 1,
          [&](int index) {
            if (!IsKept(index)) ResolveTileOf(filler, index, rows_);
          },
          stop_));
    }
    OcclusionSum sum;
    sum.count = drawn_;
    sum.note = std::to_string(lit_) + " tiles lit: nothing in their shafts; polygons of blocks in " +
               std::to_string(resolved_);
    if (options_.is_sparse) sum.note += "; " + std::to_string(interpolated_) + " blocks interpolated";
    if (options_.rows == 0) sum.chosen_options = {{"rows", std::to_string(rows_)}};
    for (float& error : errors_) error = std::max(error, 0.0f);
    sum.sums = std::move(hidden_);
    sum.errors = std::move(errors_);
    sum.has_independent_errors = !options_.is_sparse;
    return sum;
  }

 private:
  TileFiller MakeFiller(bool is_sparse) const {
    return TileFiller(receivers_, data_.light, data_.tree.space, data_.seed, is_sparse);
  }

  void ResolveTileOf(const TileFiller& filler, int index, int rows) {
    thread_local Tile tile;
    if (filler.Fill(index, &tile)) ResolveFilled(rows, &tile);
  }

  void ResolveFilled(int rows, Tile* tile) {
    thread_local std::vector<Tile> apart;
    SplitTile(tile, &apart);
    bool is_lit = true;
    const auto resolve = [&](const Tile& part) {
      const uint32_t polygons = ResolvePart(part, rows);
      is_lit = is_lit && polygons == 0;
    };
    resolve(*tile);
    std::for_each(apart.begin(), apart.end(), resolve);
    ++(is_lit ? lit_ : resolved_);
  }

  // Returns the length of its list.
  uint32_t ResolvePart(const Tile& tile, int rows) {
    thread_local TileScratch scratch;
    thread_local TileResult result;
    ResolveTile(data_.tree, data_.masks, tile, rows, &scratch, &result);
    drawn_ += result.drawn;
    for (int i = 0; i < Tile::kMost; ++i) {
      if ((tile.active[i / Tile::kLanes] >> (i % Tile::kLanes) & 1) == 0) continue;
      hidden_[tile.index[i]] = result.hidden[i];
      const float of_coins = result.coin_error[i];
      const float of_edges = kErrorOfDisagreement * std::max(0.0f, result.disagreement[i] - of_coins / kErrorOfCoins);
      errors_[tile.index[i]] = of_edges + of_coins;
      if (!coin_errors_.empty()) coin_errors_[tile.index[i]] = of_coins;
    }
    return result.polygons;
  }

  // Blocks that the grid tells, and the rest.
  void ResolveBetween(const SparseGrid& grid, const TileFiller& filler, int index) {
    thread_local Tile tile;
    constexpr int kAcross = 4;  // blocks of a tile
    const int tiles_across = (grid.columns() + kAcross - 1) / kAcross;
    const int left = index % tiles_across * kAcross, top = index / tiles_across * kAcross;
    uint32_t left_over = 0;
    for (int block = 0; block < Tile::kBlocks; ++block) {
      const int column = left + block % kAcross, row = top + block / kAcross;
      if (column >= grid.columns() || row >= grid.rows()) continue;
      if (grid.Interpolate(column, row, MostBend(), &hidden_, &errors_)) {
        ++interpolated_;
      } else {
        left_over |= 1u << block;
      }
    }
    if (left_over != 0 && filler.Fill(index, &tile) && KeepBlocks(left_over, &tile)) ResolveFilled(rows_, &tile);
  }

  // Samples are off by about a 16th of that anyway.
  float MostBend() const { return 0.5f / float(rows_); }

  // A sample of the tiles with few rows says how far those are off, and so how many are wanted. Where that are no more,
  // the sample is a part of the picture.
  absl::Status ChooseRows(const TileFiller& filler) {
    constexpr int kMostEvery = 16, kLeastTiles = 48;
    const int every = std::clamp(filler.count() / kLeastTiles, 1, kMostEvery);
    rows_ = kFewestRows;
    if (receivers_.size() < size_t(kMostEvery) * Tile::kMost) {
      rows_ = kRowsOfFewReceivers;
      return absl::OkStatus();
    }
    // Every column and row of tiles has its share: 11 is prime to all but itself. Of small pictures more than a 16th is
    // taken.
    sampled_ = filler.count() / every;
    const bool is_cluttered =
        std::any_of(data_.masks.begin(), data_.masks.end(), [](const RayMask& mask) { return !mask.is_blend(); });
    const bool reads_picture = !is_cluttered && !receivers_.ArePoints();
    std::vector<PictureError> of_tiles(reads_picture ? size_t(sampled_) : 0);
    const auto sample = [&](int i) {
      const int tile = SampledTile(i, every);
      ResolveTileOf(filler, tile, kFewestRows);
      if (reads_picture) of_tiles[size_t(i)] = ErrorOfTile(tile);
    };
    RETURN_IF_ERROR(ParallelFor(sampled_, 1, sample, stop_));
    double sum = 0, sum_of_coins = 0;
    uint64_t count = 0;
    for (size_t i = 0; i < hidden_.size(); ++i) {
      if (errors_[i] < 0 || hidden_[i] <= kPenumbraMargin) continue;
      sum += errors_[i];
      if (!coin_errors_.empty()) sum_of_coins += coin_errors_[i];
      ++count;
    }
    if (reads_picture) {
      sum = 0;
      for (const PictureError& of_tile : of_tiles) sum += kErrorOfTold * of_tile.sum;
    }
    const double each = 1 / double(std::max<uint64_t>(count, 1));
    const double of_coins = std::min(sum, sum_of_coins) * each, of_edges = sum * each - of_coins;
    const auto error_of = [&](int rows) {
      const double more = double(rows) / kFewestRows;
      const double edges = is_cluttered         ? std::pow(more, -kErrorRateOfLeaves)
                           : rows > kFewestRows ? kErrorOfTwiceTheRows * 2 / more
                                                : 1;
      return of_edges * edges + of_coins * std::pow(more, -kErrorRateOfCoins);
    };
    while (rows_ < kMostRowsChosen && error_of(rows_) > options_.max_error) rows_ *= 2;
    const double growth = is_cluttered ? kGrowthOfCoarseRowsOfLeaves : kGrowthOfCoarseRows;
    if (error_of(kFewestRows) * growth <= options_.max_error) rows_ = kCoarseRows;
    if (const uint64_t polygons = drawn_ * uint64_t(every);
        !receivers_.ArePoints() && options_.most_polygons > 0 && polygons > options_.most_polygons) {
      return absl::ResourceExhaustedError("shaft: lists of about " + std::to_string(polygons) + " polygons, and over " +
                                          std::to_string(options_.most_polygons) + " are dearer than rays");
    }
    if (rows_ <= kFewestRows && !is_sparse_) {
      kept_every_ = every;
      return absl::OkStatus();
    }
    hidden_.assign(hidden_.size(), 0);
    errors_.assign(errors_.size(), -1);
    drawn_ = 0;
    lit_ = resolved_ = 0;
    return absl::OkStatus();
  }

  // Of a tile of pixels that was resolved.
  PictureError ErrorOfTile(int tile) const {
    constexpr int kSide = 16;  // of TileFiller's, and of ExpectPictureError's
    const int tiles_across = (receivers_.width + kSide - 1) / kSide;
    const int left = tile % tiles_across * kSide, top = tile / tiles_across * kSide;
    Image visibility_and_share(kSide, kSide, 2);
    std::vector<float> errors(size_t(kSide) * kSide, 0);
    CpuReceivers pixels;
    pixels.width = pixels.height = kSide;
    pixels.planes.resize(errors.size());
    for (int y = 0; y < std::min(kSide, receivers_.height - top); ++y) {
      for (int x = 0; x < std::min(kSide, receivers_.width - left); ++x) {
        const size_t from = (size_t(top) + y) * size_t(receivers_.width) + size_t(left) + x, to = size_t(kSide) * y + x;
        if (errors_[from] < 0) continue;
        visibility_and_share.at(x, y, 0) = 1 - hidden_[from];
        visibility_and_share.at(x, y, 1) = 1;
        errors[to] = errors_[from];
        pixels.planes[to] = receivers_.planes[from];
      }
    }
    return ExpectPictureError(visibility_and_share, errors, &pixels);
  }

  static int SampledTile(int i, int every) { return i * every + i * 11 % every; }
  bool IsKept(int tile) const {
    return kept_every_ > 0 && tile / kept_every_ < sampled_ && tile == SampledTile(tile / kept_every_, kept_every_);
  }

  // What a picture is off by, of what its samples say (plan/cost_model.h).
  static constexpr double kErrorOfTold = 0.85;
  static constexpr int kFewestRows = 8, kMostRowsChosen = 64, kRowsOfFewReceivers = 16;
  // For coarse errors; no option of its own. Between 8 and 4 rows errors grow by 2.3 to 2.7, of leaves by less.
  static constexpr int kCoarseRows = 4;
  static constexpr double kGrowthOfCoarseRows = 2.8, kGrowthOfCoarseRowsOfLeaves = 2.2;
  // Of 8 rows, what 16 are off by; from there on rows that double halve it. Where there are masks, and of coins, they
  // divide it by 2^rate (trees_masked .0090, .0051, .0033).
  static constexpr double kErrorOfTwiceTheRows = 0.44, kErrorRateOfLeaves = 0.75, kErrorRateOfCoins = 0.5;

  const ShaftLightData& data_;
  const CpuReceivers& receivers_;
  const ShaftOptions options_;
  const bool is_sparse_;
  const std::function<absl::Status()> stop_;
  int rows_ = 0;
  int sampled_ = 0, kept_every_ = 0;    // tiles; one of so many is kept as it was sampled, 0: none
  std::vector<float> coin_errors_;      // of errors_; empty where no mask is BLEND
  std::vector<float> hidden_, errors_;  // an error below 0: not evaluated
  std::atomic<uint64_t> drawn_ = 0;
  std::atomic<int> lit_ = 0, resolved_ = 0, interpolated_ = 0;  // tiles
};

}  // namespace

MethodNeeds ShaftMethod::Needs(const MethodOptions&, const SceneFacts&) const {
  return {.cpu_receivers = true, .scene_data = true};
}

absl::StatusOr<std::unique_ptr<SceneData>> ShaftMethod::BuildSceneData(const DrawContext& draw,
                                                                       const FlatScene& scene) const {
  ASSIGN_OR_RETURN(MeshShapes shapes, BuildMeshShapes(scene, [&draw] { return draw.pacer->Finish(); }));
  return std::make_unique<ShaftSceneData>(std::move(shapes));
}

absl::StatusOr<std::unique_ptr<LightData>> ShaftMethod::BuildLightData(const DrawContext&, const LightInputs& inputs,
                                                                       const MethodOptions&) const {
  const MeshShapes& shapes = static_cast<const ShaftSceneData&>(*inputs.scene_data).shapes;
  ASSIGN_OR_RETURN(CpuOccluders occluders,
                   BuildCpuOccluders(*inputs.scene, *inputs.pose, shapes.kept_meshes, inputs.light, *inputs.decoder));
  const uint64_t copied = occluders.triangles.indices.size() / 3;
  const auto check_room = [&](uint64_t bytes) {
    if (bytes <= inputs.light_cache_bytes) return absl::OkStatus();
    return absl::ResourceExhaustedError("shaft: its light data take " + std::to_string(bytes) + " bytes and more, " +
                                        std::to_string(copied) + " triangles copied; the light cache holds " +
                                        std::to_string(inputs.light_cache_bytes) + "; ray has no such bound");
  };
  // Before any is made: two triangles are one polygon at best.
  RETURN_IF_ERROR(check_room(copied / 2 * sizeof(Polygon)));
  auto data = std::make_unique<ShaftLightData>();
  data->scene_data = inputs.scene_data;
  data->tree = BuildPolygonTree(occluders, shapes.shapes, inputs.light);
  data->masks = std::move(occluders.masks);
  data->light = inputs.light;
  data->seed = inputs.seed;
  RETURN_IF_ERROR(check_room(data->SizeBytes()));
  return data;
}

absl::StatusOr<OcclusionSum> ShaftMethod::ResolveOcclusion(const DrawContext& draw, const LightData& data,
                                                           const Receivers& receivers,
                                                           const MethodOptions& options) const {
  return Resolve(static_cast<const ShaftLightData&>(data), *receivers.on_cpu, std::get<ShaftOptions>(options),
                 [&draw] { return draw.pacer->Finish(); })
      .Run();
}

std::vector<std::pair<std::string, std::string>> ShaftMethod::DescribeOptions(const MethodOptions& options) const {
  const auto& shaft = std::get<ShaftOptions>(options);
  return {{"rows", shaft.rows == 0 ? kChosen : std::to_string(shaft.rows)},
          {"sparse", shaft.is_sparse ? "true" : "false"}};
}

}  // namespace halfshade
