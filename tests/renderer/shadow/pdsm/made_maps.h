// Depth maps of rectangles and spheres, traced at texel centres in double: what a rasteriser would draw, without one.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/shadow/pdsm/pdsm_grid.h"

namespace halfshade::pdsm {

// All in the light's frame, metres; the light is a square of edge light_m around the origin.
struct Sphere {
  glm::dvec3 center{0};
  double radius = 0;
};
struct Plate {  // parallel to the light
  glm::dvec2 low{0}, high{0};
  double z = 1;
};
struct MadeOccluders {
  double light_m = 1;
  std::vector<Sphere> spheres;
  std::vector<Plate> plates;
};

// `count` spheres of radius .02 to .1 in the box |x|, |y| <= .6, .6 <= z <= 1.
MadeOccluders Clutter(int count, uint32_t seed, double light_m);

struct MadeMaps {
  Grid grid;
  std::vector<SampleMap> maps;
};
// k points of the light: a Hammersley set, so that no two share a coordinate.
MadeMaps DrawMaps(const MadeOccluders& occluders, int k, int map_size, int pdsm_size);
// Of these points.
MadeMaps DrawMapsFrom(const MadeOccluders& occluders, const std::vector<glm::dvec2>& points, int map_size,
                      int pdsm_size);

// The slopes of ray (column, row).
glm::dvec2 RayOf(const Grid& grid, const glm::ivec2& ray);

// The part of the square light that the plate, at z = 1, hides from a point (x, y, z), z > 1: the closed form.
double HiddenByPlate(const MadeOccluders& plate, const glm::dvec2& place, double z);

}  // namespace halfshade::pdsm
