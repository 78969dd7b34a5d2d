// The gather (gather.h) as a pass of GL: the same numbers within the precision of floats, for contexts with a GPU.
#pragma once

#include <absl/status/statusor.h>

#include <span>
#include <vector>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/handles.h"
#include "renderer/gl/texture.h"
#include "renderer/light/binned_map.h"
#include "renderer/light/receivers.h"
#include "renderer/light/sub_lights.h"

namespace halfshade {

// A binned map in GL's memory.
struct BinnedMapOnGl {
  BinnedMap map;       // without depths and sums
  gl::Texture depths;  // R32F
  gl::Buffer sums;
  uint64_t SizeBytes() const;
};

absl::StatusOr<BinnedMapOnGl> UploadBinnedMap(const gl::Context& context, BinnedMap map);

// Adds to `sums` (RG32F, cleared by the caller), per receiver, its share of the sub-light above its plane times the
// hidden fraction, and that share. `layers` as in GatherTile, `half_edges` of the sub-light.
absl::Status GatherOnGl(const DrawContext& draw, std::span<const BinnedMapOnGl> layers, const glm::dvec2& half_edges,
                        const AreaLight& light, const Receivers& receivers, const gl::Texture& sums);

}  // namespace halfshade
