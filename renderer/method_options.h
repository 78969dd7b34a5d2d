// What a shadow method may be told: plain values that server/validate_method has already checked. Ranges and meanings
// are those of method.proto.
#pragma once

#include <cstdint>
#include <variant>

namespace halfshade {

struct HardOptions {
  int map_size = 2048;  // texels a side, 16..8192
};
struct MultiMapOptions {
  int k = 64;           // maps, 1..4096
  int map_size = 1024;  // texels a side, 16..8192
};
struct RayOptions {
  int rays = 256;  // at each receiver, 1..65536; the most, where adaptive
  bool is_adaptive = false;
  float stop_error = 0.005f;  // of adaptive rays, in (0, 1)
  float max_error = 0;        // instead of it, where above 0: wanted mean over shadowed receivers
  bool is_filtered = false;   // shared by neighbouring pixels (light/trace_filtered.h); not with is_adaptive
};
enum class FilterWeights : uint8_t {
  kMean,      // a rectangular light
  kGaussian,  // over 1.31 times the light: as wide in its deviation, smoother
};
struct PcssOptions {
  int map_size = 1024;   // texels a side, 16..8192
  int blocker_taps = 7;  // a side of the blocker search, odd, 1..63
  int filter_taps = 15;  // a side of the filter, odd, 1..127
  FilterWeights weights = FilterWeights::kMean;
  bool skips = true;  // tiles that a min/max pyramid proves lit or dark; the same bits either way
};
enum class SsmAccumulation : uint8_t {
  kBinned,   // depth-binned summed-area tables
  kScatter,  // additive blending of penumbra extents, as printed; on a soft shadow map alone
};
enum class SsmBlend : uint8_t { kFp32, kFp16, kFp16Batched };  // of kScatter
struct SsmOptions {
  int occluder_map_size = 0;      // patches a side, 16..1024; 0: chosen
  int passes = 1;                 // occluder layers: the nearest surfaces, and the furthest; 1 or 2
  int sub_lights = 0;             // along each edge of the light, 1..8; 0: chosen
  int bins = 4;                   // slabs of depth, 1..16
  bool measures_coverage = true;  // of each patch, by four texels
  SsmAccumulation accumulation = SsmAccumulation::kBinned;
  SsmBlend blend = SsmBlend::kFp32;
  // Receivers look their visibility up in a soft shadow map of RenderRequest::light_map_size, light data itself.
  // kScatter needs it.
  bool projects_map = false;
};
enum class PdsmConstruction : uint8_t {
  kTraversal,  // Algorithm 1 of the paper
  kScatter,    // the same events, sent from the maps' texels
  kSlices,     // exact at some depths, straight between
};
enum class PdsmLayout : uint8_t {
  kIndexed,  // compressed functions
  kVolume,   // slices; of construction kSlices alone
};
enum class PdsmFilter : uint8_t { kNearest, kBilinear, kWide2, kWide3 };
struct PdsmOptions {
  int k = 64;           // samples of the light, 4..256
  int map_size = 512;   // texels a side of each sample's map, at most; 16..8192
  int pdsm_size = 512;  // rays a side, 16..4096
  float eps = 0.01f;    // of compression, 1/(2k) (soft events: .001) to below .5
  PdsmConstruction construction = PdsmConstruction::kSlices;
  PdsmLayout layout = PdsmLayout::kVolume;
  PdsmFilter filter = PdsmFilter::kBilinear;
  bool has_soft_events = false;  // an edge's event is a ramp over its sample's stratum; of kIndexed by kScatter
  bool is_surface_only = false;  // eps holds at and behind surfaces, in light and in umbra; of kIndexed
};
enum class SssmThresholds : uint8_t {
  kRelative,  // fractions of the receiver's depth from the light
  kAbsolute,  // metres
};
struct SssmOptions {
  int map_size = 1024;   // texels a side, 16..8192
  int blocker_taps = 7;  // a side of the blocker search, odd, 1..63
  int filter_taps = 15;  // a side of the filter, odd, 1..127
  FilterWeights weights = FilterWeights::kGaussian;
  bool skips = true;    // tiles that a min/max pyramid proves lit or dark; the same bits either way
  float alpha = 0.10f;  // rows of blockers are shared below this difference of depth, 0..1e6; 0: none
  float beta = 0.10f;   // blurred rows, likewise
  SssmThresholds thresholds = SssmThresholds::kRelative;
  int sub_lights = 1;  // cells along each edge of the light, with a map each, 1..8
};
struct ShaftOptions {
  int rows = 0;                // of 32 samples of the light each: 8, 16, 32 or 64; 0: chosen
  bool is_sparse = false;      // one pixel of each smooth block, and what is between them
  float max_error = 0.002f;    // where rows are chosen: wanted mean over shadowed receivers, > 0
  uint64_t most_polygons = 0;  // of all blocks of a picture whose rows are chosen; 0: any number
};
using MethodOptions = std::variant<HardOptions, MultiMapOptions, RayOptions, PcssOptions, SsmOptions, PdsmOptions,
                                   SssmOptions, ShaftOptions>;

}  // namespace halfshade
