#include "renderer/shadow/pdsm/pdsm_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace halfshade::pdsm {
namespace {

// Crossings of one axis: at `depth` the ray goes on into the next cell.
struct Crossing {
  float depth = 0;
  glm::ivec2 move{0};
};

// Along one axis the ray stands at texel coordinate start - slope d: falls toward `start` as d falls if slope < 0.
// Returns the cell at d = 1 and appends the crossings below it, down to far_depth.
int CrossAxis(double start, double slope, const glm::ivec2& axis, float far_depth, std::vector<Crossing>* crossings) {
  const double first = start - slope;
  if (slope == 0) return int(std::floor(first));
  const bool is_rising = slope > 0;  // as d falls
  // A border that the ray stands on at d = 1 has been crossed.
  const int cell = is_rising ? int(std::floor(first)) : int(std::ceil(first)) - 1;
  for (int next = cell;; next += is_rising ? 1 : -1) {
    const double border = is_rising ? next + 1 : next;
    const auto depth = float((start - border) / slope);
    if (!(depth > far_depth)) break;
    if (depth < 1) crossings->push_back({depth, is_rising ? axis : -axis});
  }
  return cell;
}

}  // namespace

Grid MakeGrid(const GridNeeds& needs) {
  // What is seen edge-on has no extent of its own.
  const auto extent_of = [](const Window& window) {
    const double least = std::ldexp(std::max({1.0, std::abs(window.u0), std::abs(window.v0)}), -20);
    return glm::dvec2(std::max(window.u1 - window.u0, least), std::max(window.v1 - window.v0, least));
  };
  glm::dvec2 map_extent(0);
  for (const Window& window : needs.maps) map_extent = glm::max(map_extent, extent_of(window));
  const glm::dvec2 least_map_texel = map_extent / double(needs.map_size - 3);
  const Window& rays = needs.rays;
  Grid grid;
  grid.size = needs.pdsm_size;
  grid.texel = glm::max(extent_of(rays) / double(grid.size), least_map_texel);
  const glm::dvec2 ratio = grid.texel / least_map_texel;
  grid.map_texels = std::max(1, int(std::min(ratio.x, ratio.y)));
  const glm::dvec2 middle = 0.5 * (glm::dvec2(rays.u0, rays.v0) + glm::dvec2(rays.u1, rays.v1));
  grid.corner = middle - 0.5 * grid.texel * double(grid.size);
  // Beside the window a border on either side and the texel by which it may begin earlier. A window that is a whole
  // number of texels wide but for rounding needs no further one.
  const glm::dvec2 texels = glm::ceil(map_extent / grid.MapTexel() - 1e-9) + 3.0;
  grid.map_size = std::min(needs.map_size, int(std::max(texels.x, texels.y)));
  const glm::dvec2 least_z = needs.half_edges / (grid.MapTexel() * double(kMaxCrossings));
  grid.z_near = std::max({needs.z_near, least_z.x, least_z.y});
  return grid;
}

glm::dvec2 MapCorner(const Grid& grid, const Window& window, size_t index) {
  // The R2 sequence (Roberts 2018): the fractions of multiples of powers of the plastic number's inverse.
  const glm::dvec2 shift = glm::fract(double(index) * glm::dvec2(0.7548776662466927, 0.5698402909980532));
  return glm::dvec2(window.u0, window.v0) - grid.MapTexel() * (1.0 + shift);
}

SamplePath MakePath(const Grid& grid, const glm::dvec2& point, const glm::dvec2& map_corner, float far_depth) {
  const glm::dvec2 start = (grid.corner - map_corner) / grid.MapTexel() + 0.5 * grid.map_texels;
  const glm::dvec2 slope = point / (grid.z_near * grid.MapTexel());
  std::vector<Crossing> crossings;
  SamplePath path;
  SamplePath::Step step;
  step.depth = std::numeric_limits<float>::infinity();
  step.cell.x = CrossAxis(start.x, slope.x, {1, 0}, far_depth, &crossings);
  step.cell.y = CrossAxis(start.y, slope.y, {0, 1}, far_depth, &crossings);
  path.steps.push_back(step);
  std::stable_sort(crossings.begin(), crossings.end(),
                   [](const Crossing& a, const Crossing& b) { return a.depth > b.depth; });
  for (const Crossing& crossing : crossings) {
    step.cell += crossing.move;
    step.depth = crossing.depth;
    if (path.steps.back().depth == step.depth) {
      path.steps.back() = step;  // over a corner
    } else {
      path.steps.push_back(step);
    }
  }
  return path;
}

int SamplePath::StepAt(float depth) const {
  const auto next =
      std::partition_point(steps.begin(), steps.end(), [&](const Step& step) { return step.depth >= depth; });
  return int(next - steps.begin()) - 1;
}

}  // namespace halfshade::pdsm
