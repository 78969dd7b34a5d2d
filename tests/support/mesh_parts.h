// Parts that made scenes are put together from. Each adds to a mesh: triangles that face outward, a unit normal per
// vertex.
#pragma once

#include <functional>
#include <glm/glm.hpp>

#include "client/glb_writer.h"

namespace halfshade {

// A grid of (columns + 1) x (rows + 1) points, given by a function of (s, t) in [0,1]^2 (asked a little beyond it too),
// with smooth normals by differences.
void AddGrid(GlbMesh& mesh, int columns, int rows, const std::function<glm::dvec3(double s, double t)>& surface);

// A surface of revolution around the vertical through `base`; `profile`: (radius, height) for t in [0,1], upward.
void AddRevolution(GlbMesh& mesh, const glm::dvec3& base, int segments, int rows,
                   const std::function<glm::dvec2(double t)>& profile);

// An axis-aligned box of two triangles a face.
void AddBox(GlbMesh& mesh, const glm::dvec3& low, const glm::dvec3& high);

// A box turned by `turn_rad` about the vertical through its middle, each face cut into cells x cells. Neighbouring
// faces meet in the same points: closed once vertices are welded by position.
void AddTurnedBox(GlbMesh& mesh, const glm::dvec3& low, const glm::dvec3& high, double turn_rad, int cells);

// A closed surface around `center`: radius(direction) > 0 for unit directions. 4 rings (rings - 1) triangles that share
// their vertices; rings >= 2.
void AddStarSolid(GlbMesh& mesh, const glm::dvec3& center, int rings,
                  const std::function<double(const glm::dvec3& direction)>& radius);

}  // namespace halfshade
