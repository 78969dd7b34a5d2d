// How much of one sub-light each receiver of a tile does not see, from the sub-light's binned map.
//
// A patch of depth d hides of the light what its image on it covers: in slopes, the receiver looks at the light through
// a window of half width (L/2)(w - w_receiver) (methods of Atty et al. 2006, 3.3 and 4.2, in light perspective space).
// - Slabs beyond the receiver: of each the covered share of its own window, at the mean depth that it has there.
// - The slab in which the receiver stands, and what its own surface reaches within two patches: texel by texel, each at
//   its own depth, if it stands above the receiver's tangent plane.
// - All of the largest window covered by slabs beyond: umbra.
// What the receiver's plane leaves of the sub-light is looked through, as a rectangle (renderer/light/sub_lights.h).
#pragma once

#include <span>

#include "renderer/light/binned_map.h"
#include "renderer/light/receiver_tile.h"

namespace halfshade {

// Adds, per receiver of the tile, its share of the sub-light above its plane to share[index], and that times the hidden
// fraction to hidden[index]. `half_edges`: of the sub-light around the maps' point. `hidden_point`, where the map does
// not reach all occluders: 1 where the point itself is hidden, one a receiver, by index.
//
// `layers`: the nearest surfaces and, in the same window, the furthest where there are two; a sub-light is hidden as
// far as by the one that hides more.
void GatherTile(std::span<const BinnedMap> layers, const glm::vec2& half_edges, const ReceiverTile& tile,
                const float* hidden_point, float* hidden, float* share);

}  // namespace halfshade
