// The accumulation of the paper: each patch of an occluder map is blended into every texel of a soft shadow map that it
// may hide light from.
//
// Everything in slopes seen from a point of the light (light perspective space). Source: Atty et al. 2006, 3.2 to 3.4,
// 4.2, 4.3 and appendix A; batches from the research report of 2005, appendix A. Departures: README.md of this folder.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/handles.h"
#include "renderer/gl/texture.h"
#include "renderer/light/binned_map.h"
#include "renderer/light/receivers.h"
#include "renderer/request.h"

namespace halfshade {

// The receivers of a soft shadow map, as patches look for them.
struct ScatterReceivers {
  int size = 0;  // texels a side
  glm::dvec4 window{0};
  std::vector<float> w;  // [size][size] 1/light_z, 0: none
  float least_w = 0;     // of all that are there; 0: none is
  gl::Texture w_on_gl;   // R32F
  gl::Buffer ranges;     // the levels of a DepthPyramid over w; infinite where there is nobody
  int base_side = 0;     // squares a side of its level 0

  // The map does not reach as far as this receiver looks: what stands beyond side_slope is not in it.
  bool LeavesMap(size_t index, const BinnedMap& map, const glm::dvec2& half_edges) const;
};
absl::StatusOr<ScatterReceivers> MakeScatterReceivers(const gl::Context& context, const ReceiverMap& receivers);

// What an occluder map hides of a rectangle of the light.
struct ScatterSums {
  std::vector<float> hidden;  // [size][size] fractions, as blended: patches overlap, so sums pass 1
  uint64_t patches = 0;
  double least_width = 1;  // of the rectangle's width or height that a patch may hide from a receiver; at most 1
};

// `map`: tables are not read. The rectangle has these half edges around map.point. Submissions stay within the pacer's
// bound. The order of additions is that of the map's rows: the same sums each time.
absl::StatusOr<ScatterSums> Scatter(const DrawContext& draw, const BinnedMap& map, const glm::dvec2& half_edges,
                                    const ScatterReceivers& receivers, SsmBlend blend);

// Eq. 4: what halves can still add to a sum near 1 is a patch that hides this part of the light's width; and floats.
inline constexpr double kLeastWidthFp16 = 1.0 / 32;
inline constexpr double kLeastWidthFp32 = 1.0 / 2048;

}  // namespace halfshade
