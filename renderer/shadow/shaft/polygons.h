// What hides a light, as convex polygons of three or four corners in coordinates that the light's samples are told in.
//
// Shaft space: x and y in [0,1] over the light, z the distance from its plane in units of its larger edge. An edge of
// the light of length 0 counts as 2^-20 of the occluders' largest coordinate here: a line and a point are thin lights.
// No camera enters. Pure; no GL.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/light/cpu_occluders.h"
#include "renderer/request.h"
#include "renderer/shadow/shaft/faces.h"

namespace halfshade {

struct ShaftSpace {
  glm::dvec3 scale{1};  // shaft lengths per metre
  // Of a point in the light's frame.
  glm::dvec3 FromLight(const glm::dvec3& point_ls) const { return point_ls * scale + glm::dvec3(0.5, 0.5, 0); }
  // A normal n of the light's frame, so that n . (a - b) is the same number of metres.
  glm::dvec3 NormalFromLight(const glm::dvec3& normal_ls) const { return normal_ls / scale; }
};

// As of a Face.
struct alignas(16) Polygon {
  float x[4], y[4], z[4];
  // The plane, in metres: normal[0] x + normal[1] y + normal[2] z - offset. On a closed surface it points outward.
  float normal[3], offset = 0;
  float size_m = 0;  // largest |x| + |y| + |z| of its corners, of the light's frame
  uint8_t corners = 3;
  bool is_closed = false;  // of a closed surface in front of the light: it counts only seen from within
  uint8_t reversed = 0;    // bit k: edge k is evaluated from its end, as the polygon beside it does
  int32_t masked = -1;     // into ShaftPolygons::masked
};

// A triangle whose mask is asked at every sample that it hides.
struct MaskedTriangle {
  glm::vec3 corners[3];        // shaft space, unclipped
  MaskVertex mask_corners[3];  // texture coordinate and alpha
  glm::vec3 blend_places[3];   // of BLEND: BlendSpace::Place
  uint32_t mask = 0;           // the run of LightSpaceOccluders::masked
};

struct ShaftPolygons {
  ShaftSpace space;
  std::vector<Polygon> polygons;
  std::vector<MaskedTriangle> masked;
};

ShaftSpace MakeShaftSpace(const CpuOccluders& occluders, const AreaLight& light);

// Of a face in the light's frame, turned where its surface is known to be; false: it has no area.
bool MakePolygon(const Face& face, const ShaftSpace& space, Polygon* polygon);

// A face in the light's frame as at most two polygons: what of it is nearer than z_near is cut off.
struct PolygonParts {
  Polygon polygons[2];
  int count = 0;
};
PolygonParts MakePolygons(const Face& face, float z_near, const ShaftSpace& space);

// Of what is not kept, cut at occluders.triangles.hull.z_near().
ShaftPolygons BuildShaftPolygons(const CpuOccluders& occluders, const AreaLight& light);

}  // namespace halfshade
