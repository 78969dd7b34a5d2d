#include "renderer/shadow/shaft/polygons.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "renderer/shadow/shaft/topology.h"

namespace halfshade {
namespace {

constexpr double kUlp = 1.1920929e-7;

double Size(const glm::vec3& p) { return std::abs(p.x) + std::abs(p.y) + std::abs(p.z); }

// Builds the polygons of one light, triangle by triangle.
class Builder {
 public:
  Builder(const LightSpaceOccluders& occluders, const AreaLight& light)
      : occluders_(occluders), topology_(FindTopology(occluders.positions, occluders.indices, float(ZNear()))) {
    float largest = 0;
    for (const uint32_t i : occluders.indices) {
      const glm::vec3 p = glm::abs(occluders.positions[i]);
      largest = std::max({largest, p.x, p.y, p.z});
    }
    const double least_edge = largest > 0 ? std::ldexp(1.0, std::ilogb(largest) - 20) : 1;
    const double width = std::max(light.width_m, least_edge), height = std::max(light.height_m, least_edge);
    result_.space.scale = {1 / width, 1 / height, 1 / std::max(width, height)};
  }

  ShaftPolygons Build() {
    const auto count = uint32_t(occluders_.indices.size() / 3);
    std::vector<bool> is_done(count, false);
    const uint32_t first_masked =
        occluders_.masked.empty() ? count : occluders_.masked.front().first_index / 3;  // they stand last
    result_.polygons.reserve(count);
    for (uint32_t t = 0; t < first_masked; ++t) {
      if (is_done[t]) continue;
      std::vector<glm::vec3> corners = {Corner(t, 0), Corner(t, 1), Corner(t, 2)};
      for (uint32_t k = 0; k < 3 && corners.size() == 3; ++k) {
        const uint32_t other = topology_.neighbours[3 * t + k];
        if (other == kNoTriangle || other >= first_masked || is_done[other]) continue;
        if (AddFourth(t, k, other, &corners)) is_done[other] = true;
      }
      if (topology_.closed[t] == 2) std::reverse(corners.begin(), corners.end());
      Add(corners, topology_.closed[t] != 0, -1);
    }
    for (uint32_t run = 0; run < occluders_.masked.size(); ++run) AddMasked(run);
    return std::move(result_);
  }

 private:
  double ZNear() const { return occluders_.hull.z_near(); }
  const glm::vec3& Corner(uint32_t triangle, uint32_t k) const {
    return occluders_.positions[occluders_.indices[3 * triangle + k % 3]];
  }

  // Of the neighbour across edge k, if the four make a plane convex quad.
  bool AddFourth(uint32_t t, uint32_t k, uint32_t other, std::vector<glm::vec3>* corners) const {
    const glm::dvec3 begin = Corner(t, k), end = Corner(t, k + 1), own = Corner(t, k + 2);
    // Its corner that is neither.
    glm::vec3 fourth_corner = Corner(other, 0);
    for (uint32_t j = 1; j < 3; ++j) {
      if (glm::dvec3(fourth_corner) == begin || glm::dvec3(fourth_corner) == end) fourth_corner = Corner(other, j);
    }
    const glm::dvec3 fourth = fourth_corner;
    const glm::dvec3 normal = glm::cross(end - begin, own - begin);
    const double length = glm::length(normal);
    if (length == 0) return false;
    // Plane as far as the corners are known, and to a millionth of its size: less than any sample sees.
    const double size = std::max({Size(Corner(t, 0)), Size(Corner(t, 1)), Size(Corner(t, 2)), Size(fourth_corner)});
    const double extent = std::max(glm::length(end - begin), glm::length(fourth - own));
    if (std::abs(glm::dot(normal, fourth - begin)) / length > 4 * kUlp * size + 1e-6 * extent) return false;
    const bool turns_at_begin = glm::dot(glm::cross(begin - own, fourth - begin), normal) > 0;
    const bool turns_at_end = glm::dot(glm::cross(end - fourth, own - end), normal) > 0;
    const bool turns_at_fourth = glm::dot(glm::cross(fourth - begin, end - fourth), normal) > 0;
    if (!turns_at_begin || !turns_at_end || !turns_at_fourth) return false;
    *corners = {Corner(t, k + 2), Corner(t, k), fourth_corner, Corner(t, k + 1)};
    return true;
  }

  void AddMasked(uint32_t run) {
    const MaskedOccluders& masked = occluders_.masked[run];
    for (uint32_t i = masked.first_index; i < masked.first_index + masked.index_count; i += 3) {
      MaskedTriangle triangle;
      triangle.mask = run;
      std::vector<glm::vec3> corners;
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t vertex = occluders_.indices[i + k];
        corners.push_back(occluders_.positions[vertex]);
        triangle.corners[k] = glm::vec3(result_.space.FromLight(corners.back()));
        triangle.mask_corners[k] = occluders_.mask_vertices[vertex - occluders_.first_masked_vertex];
      }
      result_.masked.push_back(triangle);
      Add(corners, false, int32_t(result_.masked.size()) - 1);
    }
  }

  // A convex plane polygon of three or four corners in the light's frame.
  void Add(const std::vector<glm::vec3>& corners, bool is_closed, int32_t masked) {
    const auto z_near = float(ZNear());
    std::vector<glm::vec3> kept;  // five at most
    for (size_t k = 0; k < corners.size(); ++k) {
      const glm::vec3 &a = corners[k], &b = corners[(k + 1) % corners.size()];
      if (a.z >= z_near) kept.push_back(a);
      if ((a.z >= z_near) == (b.z >= z_near)) continue;
      const bool swaps = a.z > b.z;  // the same point for the polygon beside
      const glm::dvec3 low = swaps ? b : a, high = swaps ? a : b;
      kept.emplace_back(glm::vec3(glm::mix(low, high, (double(z_near) - low.z) / (high.z - low.z))));
      kept.back().z = z_near;
    }
    if (kept.size() < 3) return;
    for (size_t first = 1; first + 1 < kept.size(); first += 2) {
      const size_t last = std::min(first + 2, kept.size() - 1);
      AddPolygon({kept[0], kept[first], kept[first + 1], kept[last]}, last == first + 1 ? 3 : 4, is_closed, masked);
    }
  }

  void AddPolygon(const glm::vec3 (&corners)[4], int count, bool is_closed, int32_t masked) {
    Polygon polygon;
    for (int k = 0; k < 4; ++k) {
      const glm::vec3 p(result_.space.FromLight(corners[k]));
      polygon.x[k] = p.x;
      polygon.y[k] = p.y;
      polygon.z[k] = p.z;
      polygon.size_m = std::max(polygon.size_m, float(Size(corners[k])));
    }
    const auto arm = [&](int k) { return glm::dvec3(corners[k]) - glm::dvec3(corners[0]); };
    // Of both halves of a quad.
    const glm::dvec3 normal = glm::cross(arm(1), arm(2)) + glm::cross(arm(2), arm(3));
    const double area = glm::length(normal);
    if (!(area > 0)) return;
    const glm::dvec3 unit = normal / area;
    const glm::dvec3 in_shaft = result_.space.NormalFromLight(unit);
    for (int k = 0; k < 3; ++k) polygon.normal[k] = float(in_shaft[k]);
    polygon.offset = float(glm::dot(in_shaft, result_.space.FromLight(corners[0])));
    polygon.corners = uint8_t(count);
    polygon.is_closed = is_closed;
    polygon.masked = masked;
    for (int k = 0; k < count; ++k) {
      const int j = (k + 1) % count;
      const bool is_reversed =
          std::tie(polygon.x[j], polygon.y[j], polygon.z[j]) < std::tie(polygon.x[k], polygon.y[k], polygon.z[k]);
      polygon.reversed = uint8_t(polygon.reversed | (int(is_reversed) << k));
    }
    result_.polygons.push_back(polygon);
  }

  const LightSpaceOccluders& occluders_;
  const Topology topology_;
  ShaftPolygons result_;
};

}  // namespace

ShaftPolygons BuildShaftPolygons(const LightSpaceOccluders& occluders, const AreaLight& light) {
  return Builder(occluders, light).Build();
}

}  // namespace halfshade
