// A light cut into cells, each a light of its own: visibility is their mean, exactly. Light frame, metres. Pure; no GL.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/request.h"

namespace halfshade {

struct SubLights {
  std::vector<glm::dvec2> centers;
  glm::dvec2 half_edges{0};  // of each
};

// q x q cells; along an edge of length 0 there is one.
SubLights MakeSubLights(const AreaLight& light, int q);
// One of them as a light of its own: in the same plane, with the same axes.
AreaLight SubLight(const AreaLight& light, const SubLights& cells, size_t index);

// What a receiver's plane leaves of a cell, as a rectangle: the same middle and the same spread along both axes, so
// that a cut along an axis is exact.
struct LitPart {
  float share = 0;      // of the cell's area
  glm::vec2 middle{0};  // from the cell's centre
  glm::vec2 half_edges{0};
};

// The plane is `height` below the cell's centre (above: negative) and falls by `normal` . (x, y) toward (x, y).
LitPart CutCell(const glm::vec2& half_edges, const glm::vec2& normal, float height);

}  // namespace halfshade
