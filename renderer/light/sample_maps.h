// Depth maps from points of a light, and how many of those points each receiver cannot see. HARD is one point,
// MULTI_MAP k of them.
//
// Every map is a frustum from its point, image plane parallel to the light, over the occluders' window (window.h);
// where occluders come closer to the light's plane than kMaxWindowSlope, four side maps a point take the rest of the
// half space, so that nothing is silently lit. Depth is w = 1/z, stored reversed in floats. The bias rule is geometry
// (shaders/light/resolve_sample_maps.frag). Source: methods of Atty et al. 2006, 3.1 for the map; no offset, no
// constant.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/texture.h"
#include "renderer/light/light_data.h"
#include "renderer/light/occluders_on_context.h"
#include "renderer/light/receivers.h"
#include "renderer/request.h"

namespace halfshade {

class SampleMaps : public LightData {
 public:
  // kAllButFront: only what stands beyond the front window, for methods with a product of their own in it. Counts say
  // nothing of the points above a receiver's plane then.
  enum class Sides : uint8_t { kAll, kAllButFront };

  // Draws the maps (map_size texels a side). Where not all fit max_bytes, it keeps the occluders and as many batches of
  // maps as fit beside them; the rest are drawn in every resolve: the same pixels. `points` in the light's frame.
  static absl::StatusOr<std::unique_ptr<SampleMaps>> Create(const DrawContext& draw,
                                                            std::shared_ptr<const OccludersOnContext> occluders,
                                                            const AreaLight& light, std::vector<glm::dvec2> points,
                                                            int map_size, uint64_t max_bytes,
                                                            Sides sides = Sides::kAll);

  // RG32F [height][width]: how many points are hidden from each receiver, of how many above its tangent plane.
  absl::StatusOr<gl::Texture> CountHidden(const DrawContext& draw, const Receivers& receivers) const;

  // The map in front of the first point, where all maps are kept (asserted).
  struct FrontMap {
    const gl::Texture* maps = nullptr;  // depth w z_near; layer 0
    int map_size = 0;
    glm::dvec2 first_center{0};  // of the first texel, in slopes
    glm::dvec2 slope_per_texel{0};
    double z_near = 0;
    double side_slope = 0;  // where side maps take over; 0: every occluder is in this map
  };
  FrontMap front_map() const;

  int point_count() const { return int(points_.size()); }
  uint64_t SizeBytes() const override;
  uint64_t MapsDrawn() const override { return maps_kept_; }
  uint64_t MapsRedrawn() const override { return maps_left_out_; }

 private:
  // Maps of one side, drawn into the layers of one texture and resolved by one pass.
  struct Batch {
    int side = 0;
    int first_point = 0;
    int point_count = 0;
    glm::dvec2 slope_per_texel{0};
    gl::Texture maps;  // empty where it did not fit
  };
  absl::Status DrawLayer(const DrawContext& draw, const Batch& batch, const gl::Texture& maps, int layer) const;
  absl::Status DrawBatch(const DrawContext& draw, const Batch& batch, const gl::Texture& maps) const;
  absl::Status ResolveBatch(const DrawContext& draw, const Batch& batch, const gl::Texture& maps,
                            const Receivers& receivers) const;
  // What a point's map covers inside its border of one empty texel.
  Window WindowOf(int side, const glm::dvec2& point) const;
  // One size of texel for all maps of a side: the least in which every point's window fits.
  glm::dvec2 SlopePerTexel(int side) const;
  absl::StatusOr<gl::Texture> MakeLayers(const DrawContext& draw) const;

  std::shared_ptr<const OccludersOnContext> occluders_;  // null where all maps are kept
  OccluderHull hull_{0, 0, 1};
  AreaLight light_;
  std::vector<glm::dvec2> points_;
  int map_size_ = 0;
  int layers_ = 0;
  std::vector<Batch> batches_;
  uint64_t maps_kept_ = 0, maps_left_out_ = 0;
};

}  // namespace halfshade
