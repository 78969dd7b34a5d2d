// Depth maps of a light's samples, one after the other in memory: what a PDSM is made from.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/gl/draw_context.h"
#include "renderer/light/occluders_on_context.h"
#include "renderer/shadow/pdsm/pdsm_grid.h"

namespace halfshade::pdsm {

// The grid of a PDSM that holds all of the front window's occluders (light/window.h) and all that they hide.
Grid GridOf(const OccluderHull& hull, const glm::dvec2& half_edges, const std::vector<glm::dvec2>& points, int map_size,
            int pdsm_size);

// Calls `take` with the map of each point, in order. Its depths are those of the grid; each map is gone when the next
// one comes.
absl::Status DrawSampleMaps(const DrawContext& draw, const OccludersOnContext& occluders, const Grid& grid,
                            const std::vector<glm::dvec2>& points,
                            const std::function<absl::Status(const SampleMap&)>& take);

}  // namespace halfshade::pdsm
