// A depth map from one point of a light, in memory, with its depth-binned tables: what a receiver's view of the light
// holds, at the price of a few box sums.
#pragma once

#include <absl/status/statusor.h>

#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "renderer/gl/draw_context.h"
#include "renderer/light/depth_tables.h"
#include "renderer/light/occluders_on_context.h"
#include "renderer/light/sample_maps.h"
#include "renderer/request.h"

namespace halfshade {

enum class OccluderLayer : uint8_t {
  kNearest,   // surfaces nearest to the light
  kFurthest,  // and furthest: of a closed solid those that it turns away
};

struct BinnedMapOptions {
  int size = 256;            // patches a side
  int texels_per_patch = 2;  // along a side: 1, 2 or 4. More than 1: a patch's coverage is measured
  int slabs = 4;             // 0: no tables
  OccluderLayer layer = OccluderLayer::kNearest;
};

struct BinnedMap {
  // A whole vector of any instruction set may be read from any texel on.
  static constexpr int kPadding = 64;

  glm::dvec2 point{0};  // of the light: slopes are seen from there
  int map_size = 0;     // texels a side, a border of one empty one all around
  int texels_per_patch = 1;
  glm::dvec2 first_center{0};  // of the first texel, in slopes
  glm::dvec2 slope_per_texel{0};
  double z_near = 0;
  double side_slope = 0;      // occluders beyond it are not in this map; 0: all are
  std::vector<float> depths;  // [map_size][map_size] w z_near, 0: empty; then kPadding zeros
  DepthTables tables;
  std::unique_ptr<SampleMaps> all_sides;  // from this point; null unless side_slope

  uint64_t SizeBytes() const {
    return depths.size() * sizeof(float) + tables.SizeBytes() + (all_sides != nullptr ? all_sides->SizeBytes() : 0);
  }
};

// Draws the occluders as the point sees them. Waits for the drawing.
absl::StatusOr<BinnedMap> DrawBinnedMap(const DrawContext& draw, std::shared_ptr<const OccludersOnContext> occluders,
                                        const AreaLight& light, const glm::dvec2& point,
                                        const BinnedMapOptions& options);

}  // namespace halfshade
