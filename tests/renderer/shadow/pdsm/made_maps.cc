#include "tests/renderer/shadow/pdsm/made_maps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace halfshade::pdsm {
namespace {

std::vector<glm::dvec2> HammersleyPoints(int k, double light_m) {
  std::vector<glm::dvec2> points;
  for (int i = 0; i < k; ++i) {
    double reversed = 0;
    for (int bit = 0; bit < 16; ++bit) reversed += (i >> bit & 1) * std::ldexp(0.5, -bit);
    points.emplace_back(((i + 0.37) / k - 0.5) * light_m, (reversed + 0.5 / k - 0.5) * light_m);
  }
  return points;
}

// Slopes of all that is drawn, as seen from `point`: wide enough for spheres.
Window WindowOf(const MadeOccluders& occluders, const glm::dvec2& point) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Window window{kInfinity, kInfinity, -kInfinity, -kInfinity};
  const auto add = [&](const glm::dvec2& place, double z) {
    const glm::dvec2 slope = (place - point) / z;
    window = {std::min(window.u0, slope.x), std::min(window.v0, slope.y), std::max(window.u1, slope.x),
              std::max(window.v1, slope.y)};
  };
  for (const Plate& plate : occluders.plates) {
    add(plate.low, plate.z);
    add(plate.high, plate.z);
  }
  for (const Sphere& sphere : occluders.spheres) {
    for (const double z : {sphere.center.z - sphere.radius, sphere.center.z + sphere.radius}) {
      add(glm::dvec2(sphere.center) - sphere.radius, z);
      add(glm::dvec2(sphere.center) + sphere.radius, z);
    }
  }
  return window;
}

double NearestZ(const MadeOccluders& occluders, const glm::dvec2& point, const glm::dvec2& slope) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Plate& plate : occluders.plates) {
    const glm::dvec2 hit = point + slope * plate.z;
    const bool is_hit = glm::all(glm::greaterThan(hit, plate.low)) && glm::all(glm::lessThan(hit, plate.high));
    if (is_hit) nearest = std::min(nearest, plate.z);
  }
  const glm::dvec3 direction(slope, 1);
  for (const Sphere& sphere : occluders.spheres) {
    const glm::dvec3 from = glm::dvec3(point, 0) - sphere.center;
    const double a = glm::dot(direction, direction), b = glm::dot(direction, from);
    const double discriminant = b * b - a * (glm::dot(from, from) - sphere.radius * sphere.radius);
    if (discriminant > 0) nearest = std::min(nearest, (-b - std::sqrt(discriminant)) / a);
  }
  return nearest;
}

}  // namespace

MadeOccluders Clutter(int count, uint32_t seed, double light_m) {
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  MadeOccluders occluders;
  occluders.light_m = light_m;
  for (int i = 0; i < count; ++i) {
    occluders.spheres.push_back({{between(-0.6, 0.6), between(-0.6, 0.6), between(0.6, 1)}, between(0.02, 0.1)});
  }
  return occluders;
}

MadeMaps DrawMaps(const MadeOccluders& occluders, int k, int map_size, int pdsm_size) {
  return DrawMapsFrom(occluders, HammersleyPoints(k, occluders.light_m), map_size, pdsm_size);
}

MadeMaps DrawMapsFrom(const MadeOccluders& occluders, const std::vector<glm::dvec2>& points, int map_size,
                      int pdsm_size) {
  GridNeeds needs;
  needs.half_edges = glm::dvec2(occluders.light_m / 2);
  needs.map_size = map_size;
  needs.pdsm_size = pdsm_size;
  needs.z_near = std::numeric_limits<double>::infinity();
  for (const Plate& plate : occluders.plates) needs.z_near = std::min(needs.z_near, plate.z);
  for (const Sphere& sphere : occluders.spheres) needs.z_near = std::min(needs.z_near, sphere.center.z - sphere.radius);
  needs.rays = WindowOf(occluders, glm::dvec2(0));
  for (const glm::dvec2 corner : {glm::dvec2(-0.5), glm::dvec2(0.5)}) {
    const Window seen = WindowOf(occluders, corner * occluders.light_m);
    needs.rays = {std::min(needs.rays.u0, seen.u0), std::min(needs.rays.v0, seen.v0), std::max(needs.rays.u1, seen.u1),
                  std::max(needs.rays.v1, seen.v1)};
  }
  for (const glm::dvec2& point : points) needs.maps.push_back(WindowOf(occluders, point));
  MadeMaps made;
  made.grid = MakeGrid(needs);
  for (size_t i = 0; i < points.size(); ++i) {
    SampleMap& map = made.maps.emplace_back();
    map.point = points[i];
    map.corner = MapCorner(made.grid, needs.maps[i], i);
    for (int y = 0; y < made.grid.map_size; ++y) {
      for (int x = 0; x < made.grid.map_size; ++x) {
        const glm::dvec2 slope = map.corner + (glm::dvec2(x, y) + 0.5) * made.grid.MapTexel();
        map.depths.push_back(float(std::min(1.0, made.grid.z_near / NearestZ(occluders, map.point, slope))));
      }
    }
  }
  return made;
}

glm::dvec2 RayOf(const Grid& grid, const glm::ivec2& ray) { return grid.corner + (glm::dvec2(ray) + 0.5) * grid.texel; }

double HiddenByPlate(const MadeOccluders& plate, const glm::dvec2& place, double z) {
  const double half = plate.light_m / 2;
  // Where the plate's edges stand on the light, seen from the point.
  const auto on_light = [&](double edge, double from) { return std::clamp((edge * z - from) / (z - 1), -half, half); };
  double share = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double a = on_light(plate.plates[0].low[axis], place[axis]);
    const double b = on_light(plate.plates[0].high[axis], place[axis]);
    share *= (b - a) / plate.light_m;
  }
  return share;
}

}  // namespace halfshade::pdsm
