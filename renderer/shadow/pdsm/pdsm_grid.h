// The texels of a PDSM and of the maps of its light samples, and how a ray of the one crosses the texels of the other.
//
// Light perspective space: slopes u = x/z, v = y/z from the light's centre, depth d = z_near / z in (0, 1], growing
// toward the light. A PDSM texel (i, j) is the ray of constant (u, v) through its centre. From the light's point s the
// place at depth d of that ray has the slope u - s d / z_near: straight in d. A PDSM texel is a whole number of map
// texels wide, so that all rays of a PDSM cross the texel borders of one map at the same depths: one SamplePath serves
// them all, and every form of construction decides with its depths and nothing else. Source: St-Amour et al. 2005, 3.1
// and Fig. 4; the common path is ours. Pure; no GL.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "renderer/light/window.h"

namespace halfshade::pdsm {

struct Grid {
  int size = 0;          // n: texels a side of the PDSM
  glm::dvec2 corner{0};  // slopes of its first texel's corner
  glm::dvec2 texel{0};   // slopes a PDSM texel
  int map_size = 0;      // texels a side of every map, its border of one empty texel included
  int map_texels = 1;    // map texels a PDSM texel, a side
  double z_near = 1;     // metres
  glm::dvec2 MapTexel() const { return texel / double(map_texels); }
  size_t RayCount() const { return size_t(size) * size; }
  bool operator==(const Grid&) const = default;
};

// Depth map of one sample: d = z_near / z, 0 where nothing is; [map_size][map_size], row of smallest v first.
struct SampleMap {
  glm::dvec2 point{0};   // of the light, metres
  glm::dvec2 corner{0};  // slopes of the first texel's corner, as seen from the point
  std::vector<float> depths;
};

// What a grid is made for.
struct GridNeeds {
  Window rays;               // that the PDSM holds
  std::vector<Window> maps;  // of each sample
  glm::dvec2 half_edges{0};  // of the light, metres
  double z_near = 1;         // of the nearest occluder
  int map_size = 0, pdsm_size = 0;
};
// Neither maps nor PDSM are finer than asked; a PDSM finer than its maps is widened to their texels. The grid's z_near
// is larger than asked where a ray would cross over kMaxCrossings borders along an axis: windows cut at a slope in
// front of a light that occluders come close to. What is nearer stands at z_near then: d is at most 1.
inline constexpr int kMaxCrossings = 4096;
Grid MakeGrid(const GridNeeds& needs);

// The corner of the map of sample `index`, one to two texels before its window: texels of different samples begin at
// different places, so that what half a texel hides or shows of an edge averages out over the samples.
glm::dvec2 MapCorner(const Grid& grid, const Window& window, size_t index);

// Cells of a map that a ray meets from the light outward. From steps[q].depth down to, not including, steps[q +
// 1].depth (the last: down to 0) ray (i, j) is over texel map_texels (i, j) + steps[q].cell. The first begins at
// infinity. A ray is in the texel that it enters at the depth of the border. Depths fall strictly.
struct SamplePath {
  struct Step {
    float depth = 0;
    glm::ivec2 cell{0};
  };
  std::vector<Step> steps;
  // Index of the step that holds `depth` in (0, 1].
  int StepAt(float depth) const;
};
// Borders that are crossed at or beyond far_depth (<= 0; below 0: beyond infinity) are left out.
SamplePath MakePath(const Grid& grid, const glm::dvec2& point, const glm::dvec2& map_corner, float far_depth = 0);

}  // namespace halfshade::pdsm
