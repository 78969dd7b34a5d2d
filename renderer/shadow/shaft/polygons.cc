#include "renderer/shadow/shaft/polygons.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "renderer/shadow/shaft/topology.h"

namespace halfshade {
namespace {

constexpr double kUlp = 1.1920929e-7;
// Of a level's edges, in means of them.
constexpr double kLongestEdge = 3;

double Size(const glm::vec3& p) { return std::abs(p.x) + std::abs(p.y) + std::abs(p.z); }

// Corners of a convex plane polygon: a quad that one plane cuts has five.
struct Corners {
  glm::vec3 p[6];
  size_t count = 0;
  void Add(const glm::vec3& corner) { p[count++] = corner; }
};

// Builds the polygons of one light, triangle by triangle.
class Builder {
 public:
  Builder(const CpuOccluders& cpu_occluders, const AreaLight& light)
      : cpu_occluders_(cpu_occluders),
        occluders_(cpu_occluders.triangles),
        topology_(FindTopology(occluders_.positions, occluders_.indices, float(ZNear()))) {
    float largest = 0;
    for (const uint32_t i : occluders_.indices) {
      const glm::vec3 p = glm::abs(occluders_.positions[i]);
      largest = std::max({largest, p.x, p.y, p.z});
    }
    const double least_edge = largest > 0 ? std::ldexp(1.0, std::ilogb(largest) - 20) : 1;
    const double width = std::max(light.width_m, least_edge), height = std::max(light.height_m, least_edge);
    result_.space.scale = {1 / width, 1 / height, 1 / std::max(width, height)};
  }

  ShaftPolygons Build() {
    const auto count = uint32_t(occluders_.indices.size() / 3);
    const uint32_t first_masked =
        occluders_.masked.empty() ? count : occluders_.masked.front().first_index / 3;  // they stand last
    is_done_.assign(count, false);
    result_.polygons.reserve(count);
    for (const OccluderRun& run : occluders_.runs) {
      const std::vector<MeshLevels::Level>* levels =
          cpu_occluders_.levels == nullptr ? nullptr : &cpu_occluders_.levels->meshes[run.mesh];
      const uint32_t first = run.first_index / 3, last = first + run.index_count / 3;
      if (levels == nullptr || levels->empty()) {
        AddTriangles(first, last, first_masked, &result_.polygons);
        continue;
      }
      PolygonLevel finest;
      finest.next_error_m = float(levels->front().error * run.scale);
      finest.polygons.reserve(last - first);
      AddTriangles(first, last, first_masked, &finest.polygons);
      result_.levels.push_back(std::move(finest));
      for (size_t i = 0; i < levels->size(); ++i) AddLevel(run, *levels, i);
    }
    for (uint32_t run = 0; run < occluders_.masked.size(); ++run) AddMasked(run);
    return std::move(result_);
  }

 private:
  double ZNear() const { return occluders_.hull.z_near(); }
  const glm::vec3& Corner(uint32_t triangle, uint32_t k) const {
    return occluders_.positions[occluders_.indices[3 * triangle + k % 3]];
  }

  void AddTriangles(uint32_t first, uint32_t last, uint32_t first_masked, std::vector<Polygon>* polygons) {
    for (uint32_t t = first; t < last; ++t) {
      if (is_done_[t]) continue;
      Corners corners = {{Corner(t, 0), Corner(t, 1), Corner(t, 2)}, 3};
      for (uint32_t k = 0; k < 3 && corners.count == 3; ++k) {
        const uint32_t other = topology_.neighbours[3 * t + k];
        if (other == kNoTriangle || other >= first_masked || is_done_[other]) continue;
        if (AddFourth(t, k, other, &corners)) is_done_[other] = true;
      }
      Add(corners, topology_.closed[t], -1, polygons);
    }
  }

  // A vertex is of a closed surface where all its triangles are; a triangle where all its corners are, one way.
  const std::vector<uint8_t>& ClosedVertices() {
    if (!closed_vertices_.empty()) return closed_vertices_;
    constexpr uint8_t kUnknown = 255;
    closed_vertices_.assign(occluders_.positions.size(), kUnknown);
    for (size_t i = 0; i < occluders_.indices.size(); ++i) {
      uint8_t& closed = closed_vertices_[topology_.welded[occluders_.indices[i]]];
      const uint8_t here = topology_.closed[i / 3];
      closed = closed == kUnknown || closed == here ? here : 0;
    }
    return closed_vertices_;
  }

  void AddLevel(const OccluderRun& run, const std::vector<MeshLevels::Level>& levels, size_t index) {
    const MeshLevels::Level& level = levels[index];
    PolygonLevel result;
    result.error_m = float(level.error * run.scale);
    if (index + 1 < levels.size()) result.next_error_m = float(levels[index + 1].error * run.scale);
    result.polygons.reserve(level.indices.size() / 3);
    const std::vector<uint8_t>& closed = ClosedVertices();
    double mean_edge_m = 0;
    for (size_t i = 0; i < level.indices.size(); i += 3) {
      const auto corner = [&](size_t k) { return occluders_.positions[run.first_vertex + level.indices[i + k % 3]]; };
      for (size_t k = 0; k < 3; ++k) mean_edge_m += glm::distance(corner(k), corner(k + 1));
    }
    const auto longest_edge_m = float(kLongestEdge * mean_edge_m / double(level.indices.size()));
    for (size_t i = 0; i < level.indices.size(); i += 3) {
      Corners corners;
      uint8_t all = 255;
      for (int k = 0; k < 3; ++k) {
        const uint32_t vertex = run.first_vertex + level.indices[i + k];
        corners.Add(occluders_.positions[vertex]);
        const uint8_t here = closed[topology_.welded[vertex]];
        all = all == 255 || all == here ? here : 0;
      }
      AddInParts(corners, longest_edge_m, all == 255 ? 0 : all, &result.polygons);
    }
    result_.levels.push_back(std::move(result));
  }

  // Triangles whose edges are longer are halved there, as those beside them are: what is near a receiver and what is
  // far from it then stay apart.
  void AddInParts(const Corners& triangle, float longest_edge_m, uint8_t closed, std::vector<Polygon>* polygons) {
    size_t longest = 0;
    float length_m = 0;
    for (size_t k = 0; k < 3; ++k) {
      const glm::vec3 &a = triangle.p[k], &b = triangle.p[(k + 1) % 3];
      // The same of both triangles beside it.
      const float edge_m = glm::length(glm::abs(a - b));
      if (edge_m > length_m) {
        longest = k;
        length_m = edge_m;
      }
    }
    if (!(length_m > longest_edge_m)) {
      Add(triangle, closed, -1, polygons);
      return;
    }
    const glm::vec3 &a = triangle.p[longest], &b = triangle.p[(longest + 1) % 3], &c = triangle.p[(longest + 2) % 3];
    const glm::vec3 middle = (a + b) * 0.5f;
    AddInParts({{a, middle, c}, 3}, longest_edge_m, closed, polygons);
    AddInParts({{middle, b, c}, 3}, longest_edge_m, closed, polygons);
  }

  // Of the neighbour across edge k, if the four make a plane convex quad.
  bool AddFourth(uint32_t t, uint32_t k, uint32_t other, Corners* corners) const {
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
    *corners = {{Corner(t, k + 2), Corner(t, k), fourth_corner, Corner(t, k + 1)}, 4};
    return true;
  }

  void AddMasked(uint32_t run) {
    const MaskedOccluders& masked = occluders_.masked[run];
    for (uint32_t i = masked.first_index; i < masked.first_index + masked.index_count; i += 3) {
      MaskedTriangle triangle = {};
      triangle.mask = run;
      Corners corners;
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t vertex = occluders_.indices[i + k];
        corners.Add(occluders_.positions[vertex]);
        triangle.corners[k] = glm::vec3(result_.space.FromLight(corners.p[k]));
        const uint32_t masked_vertex = vertex - occluders_.first_masked_vertex;
        triangle.mask_corners[k] = occluders_.mask_vertices[masked_vertex];
        if (!occluders_.blend_places.empty()) triangle.blend_places[k] = occluders_.blend_places[masked_vertex];
      }
      result_.masked.push_back(triangle);
      Add(corners, 0, int32_t(result_.masked.size()) - 1, &result_.polygons);
    }
  }

  // A convex plane polygon of three or four corners in the light's frame. `closed`: Topology::closed.
  void Add(Corners corners, uint8_t closed, int32_t masked, std::vector<Polygon>* polygons) {
    if (closed == 2) std::reverse(corners.p, corners.p + corners.count);
    const auto z_near = float(ZNear());
    Corners kept;
    for (size_t k = 0; k < corners.count; ++k) {
      const glm::vec3 &a = corners.p[k], &b = corners.p[(k + 1) % corners.count];
      if (a.z >= z_near) kept.Add(a);
      if ((a.z >= z_near) == (b.z >= z_near)) continue;
      const bool swaps = a.z > b.z;  // the same point for the polygon beside
      const glm::dvec3 low = swaps ? b : a, high = swaps ? a : b;
      glm::vec3 cut(glm::mix(low, high, (double(z_near) - low.z) / (high.z - low.z)));
      cut.z = z_near;
      kept.Add(cut);
    }
    for (size_t first = 1; first + 1 < kept.count; first += 2) {
      const size_t last = std::min(first + 2, kept.count - 1);
      AddPolygon({kept.p[0], kept.p[first], kept.p[first + 1], kept.p[last]}, last == first + 1 ? 3 : 4, closed != 0,
                 masked, polygons);
    }
  }

  void AddPolygon(const glm::vec3 (&corners)[4], int count, bool is_closed, int32_t masked,
                  std::vector<Polygon>* polygons) {
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
    polygons->push_back(polygon);
  }

  const CpuOccluders& cpu_occluders_;
  const LightSpaceOccluders& occluders_;
  const Topology topology_;
  std::vector<bool> is_done_;             // triangles that are part of a quad
  std::vector<uint8_t> closed_vertices_;  // at the first vertex of each place
  ShaftPolygons result_;
};

}  // namespace

ShaftPolygons BuildShaftPolygons(const CpuOccluders& occluders, const AreaLight& light) {
  return Builder(occluders, light).Build();
}

}  // namespace halfshade
