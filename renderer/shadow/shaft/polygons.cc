#include "renderer/shadow/shaft/polygons.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace halfshade {
namespace {

// Corners of a convex plane polygon: a quad that one plane cuts has five.
struct Corners {
  glm::vec3 p[6];
  size_t count = 0;
  void Add(const glm::vec3& corner) { p[count++] = corner; }
};

// The part of a face with z >= z_near.
Corners Clip(const Face& face, float z_near) {
  Corners kept;
  for (size_t k = 0; k < face.count; ++k) {
    const glm::vec3 &a = face.corners[k], &b = face.corners[(k + 1) % face.count];
    if (a.z >= z_near) kept.Add(a);
    if ((a.z >= z_near) == (b.z >= z_near)) continue;
    const bool swaps = a.z > b.z;  // the same point for the polygon beside
    const glm::dvec3 low = swaps ? b : a, high = swaps ? a : b;
    glm::vec3 cut(glm::mix(low, high, (double(z_near) - low.z) / (high.z - low.z)));
    cut.z = z_near;
    kept.Add(cut);
  }
  return kept;
}

// Builds the polygons of one light, run by run.
class Builder {
 public:
  Builder(const CpuOccluders& cpu_occluders, const AreaLight& light)
      : occluders_(cpu_occluders.triangles),
        z_near_(float(occluders_.hull.z_near())),
        faces_(occluders_.positions, occluders_.indices, z_near_) {
    result_.space = MakeShaftSpace(cpu_occluders, light);
  }

  ShaftPolygons Build() {
    const auto count = uint32_t(occluders_.indices.size() / 3);
    const uint32_t first_masked =
        occluders_.masked.empty() ? count : occluders_.masked.front().first_index / 3;  // they stand last
    result_.polygons.reserve(count);
    for (const Face& face : faces_.Find(0, first_masked, first_masked)) Add(face, -1);
    for (uint32_t run = 0; run < occluders_.masked.size(); ++run) AddMasked(run);
    return std::move(result_);
  }

 private:
  void AddMasked(uint32_t run) {
    const MaskedOccluders& masked = occluders_.masked[run];
    for (uint32_t i = masked.first_index; i < masked.first_index + masked.index_count; i += 3) {
      MaskedTriangle triangle = {};
      triangle.mask = run;
      Face face;
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t vertex = occluders_.indices[i + k];
        face.corners[k] = face.corners[3] = occluders_.positions[vertex];
        triangle.corners[k] = glm::vec3(result_.space.FromLight(face.corners[k]));
        const uint32_t masked_vertex = vertex - occluders_.first_masked_vertex;
        triangle.mask_corners[k] = occluders_.mask_vertices[masked_vertex];
        if (!occluders_.blend_places.empty()) triangle.blend_places[k] = occluders_.blend_places[masked_vertex];
      }
      result_.masked.push_back(triangle);
      Add(face, int32_t(result_.masked.size()) - 1);
    }
  }

  void Add(const Face& face, int32_t masked) {
    const PolygonParts parts = MakePolygons(face, z_near_, result_.space);
    for (int i = 0; i < parts.count; ++i) {
      result_.polygons.push_back(parts.polygons[i]);
      result_.polygons.back().masked = masked;
    }
  }

  const LightSpaceOccluders& occluders_;
  const float z_near_;
  FaceFinder faces_;
  ShaftPolygons result_;
};

}  // namespace

ShaftSpace MakeShaftSpace(const CpuOccluders& occluders, const AreaLight& light) {
  float largest = 0;
  const auto add = [&](const glm::vec3& point) {
    const glm::vec3 p = glm::abs(point);
    largest = std::max({largest, p.x, p.y, p.z});
  };
  for (const uint32_t i : occluders.triangles.indices) add(occluders.triangles.positions[i]);
  for (const KeptPlace& place : occluders.places) {
    add(place.box_ls.min);
    add(place.box_ls.max);
  }
  const double least_edge = largest > 0 ? std::ldexp(1.0, std::ilogb(largest) - 20) : 1;
  const double width = std::max(light.width_m, least_edge), height = std::max(light.height_m, least_edge);
  return {.scale = {1 / width, 1 / height, 1 / std::max(width, height)}};
}

bool MakePolygon(const Face& face, const ShaftSpace& space, Polygon* polygon) {
  const int count = face.count;
  glm::vec3 corners[4];
  for (int k = 0; k < 4; ++k) {
    const int last = std::min(k, count - 1);
    corners[k] = face.corners[face.closed == 2 ? count - 1 - last : last];
  }
  const glm::dvec3 origin = corners[0];
  const glm::dvec3 arm1 = glm::dvec3(corners[1]) - origin, arm2 = glm::dvec3(corners[2]) - origin;
  const glm::dvec3 arm3 = glm::dvec3(corners[3]) - origin;
  // Of both halves of a quad.
  const glm::dvec3 normal = glm::cross(arm1, arm2) + glm::cross(arm2, arm3);
  const double area = glm::length(normal);
  if (!(area > 0)) return false;
  const glm::dvec3 in_shaft = space.NormalFromLight(normal / area);
  for (int k = 0; k < 3; ++k) polygon->normal[k] = float(in_shaft[k]);
  polygon->offset = float(glm::dot(in_shaft, space.FromLight(origin)));
  for (int k = 0; k < 4; ++k) {
    const glm::dvec3 p = space.FromLight(corners[k]);
    polygon->x[k] = float(p.x);
    polygon->y[k] = float(p.y);
    polygon->z[k] = float(p.z);
  }
  polygon->size_m = SizeOf(corners);
  polygon->corners = uint8_t(count);
  polygon->is_closed = face.closed != 0;
  polygon->masked = -1;
  unsigned reversed = 0;
  for (int k = 0; k < count; ++k) {
    // Lexicographically, without branches: corners come in no order.
    const int j = k + 1 < count ? k + 1 : 0;
    const float *const x = polygon->x, *const y = polygon->y, *const z = polygon->z;
    const unsigned by_z = unsigned(z[j] < z[k]);
    const unsigned by_y = unsigned(y[j] < y[k]) | (unsigned(y[j] == y[k]) & by_z);
    reversed |= (unsigned(x[j] < x[k]) | (unsigned(x[j] == x[k]) & by_y)) << k;
  }
  polygon->reversed = uint8_t(reversed);
  return true;
}

PolygonParts MakePolygons(const Face& face, float z_near, const ShaftSpace& space) {
  PolygonParts parts;
  const Corners kept = Clip(face, z_near);
  for (size_t first = 1; first + 1 < kept.count; first += 2) {
    const size_t last = std::min(first + 2, kept.count - 1);
    const Face part = {
        {kept.p[0], kept.p[first], kept.p[first + 1], kept.p[last]}, uint8_t(last == first + 1 ? 3 : 4), face.closed};
    if (MakePolygon(part, space, &parts.polygons[parts.count])) ++parts.count;
  }
  return parts;
}

ShaftPolygons BuildShaftPolygons(const CpuOccluders& occluders, const AreaLight& light) {
  return Builder(occluders, light).Build();
}

}  // namespace halfshade
