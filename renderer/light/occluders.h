// Everything that may hide a light, as one mesh in the light's frame: the first camera-free product of a light, shared
// by every map that is drawn for it (one draw call a map, whatever the number of instances).
//
// Positions are made in double from scene and light and then rounded: they are exact to half an ulp of the distance to
// the light, wherever both stand in the world. Pure; no GL.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/light/window.h"
#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"

namespace halfshade {

// A point of a mesh in the frame of a light, in double until the end. (As the product of matrix and vector, which GLM
// makes of four rows.)
inline glm::vec3 PointInLight(const glm::dmat4& light_from_mesh, const glm::vec3& point) {
  const glm::dmat4& m = light_from_mesh;
  const glm::dvec3 p(point);
  return {float((m[0].x * p.x + m[1].x * p.y) + (m[2].x * p.z + m[3].x)),
          float((m[0].y * p.x + m[1].y * p.y) + (m[2].y * p.z + m[3].y)),
          float((m[0].z * p.x + m[1].z * p.y) + (m[2].z * p.z + m[3].z))};
}

// The longest edge of what becomes of the mesh's unit cube.
double LongestAxis(const glm::dmat4& from_mesh);

// Consecutive triangles that occlude only where their material, MASK or BLEND, lets them.
struct MaskedOccluders {
  uint32_t material = 0;
  uint32_t first_index = 0;
  uint32_t index_count = 0;
};

// Texture coordinate of the base colour, and the vertex's alpha times the material's.
using MaskVertex = glm::vec3;

// One casting instance without a mask. Its vertices are the mesh's, in their order.
struct OccluderRun {
  uint32_t mesh = 0;
  uint32_t first_vertex = 0;
  uint32_t first_index = 0;
  uint32_t index_count = 0;
  double scale = 1;  // longest axis of the mesh's unit cube, metres
};

struct LightSpaceOccluders {
  std::vector<glm::vec3> positions;  // light frame, metres
  std::vector<uint32_t> indices;     // triangles with a part in front of the light's plane; both sides occlude
  std::vector<OccluderRun> runs;     // in the order of indices
  // Masked triangles and their vertices stand last: mask_vertices[i] belongs to positions[first_masked_vertex + i].
  std::vector<MaskedOccluders> masked;
  uint32_t first_masked_vertex = 0;
  std::vector<MaskVertex> mask_vertices;
  std::vector<glm::vec3> blend_places;  // beside them, BlendSpace::Place; empty where nothing is BLEND
  OccluderHull hull{0, 0, 1};
  size_t SizeBytes() const {
    return positions.size() * sizeof(glm::vec3) + indices.size() * sizeof(uint32_t) +
           mask_vertices.size() * sizeof(MaskVertex) + blend_places.size() * sizeof(glm::vec3) +
           runs.size() * sizeof(OccluderRun);
  }
};

// Casting instances that are not to be among them, but that hull.z_near() is of too.
struct OccludersElsewhere {
  std::vector<bool> stands_there;  // [instance of the pose]; empty: none does
  Box3f box_ls;                    // of those not behind the light's plane
};

// The casting instances of the pose in the frame of the light. hull.z_near() is just below the nearest occluder, or,
// where one crosses the light's plane, 2^-20 of the occluders' largest coordinate: depth maps hold w z_near in floats,
// whose precision does not depend on it. Only powers of two and maxima go into it, so that scaling scene and light by a
// power of two changes no bit of a map. Meshes of which a MASK or BLEND material leaves nothing are not there.
LightSpaceOccluders BuildLightSpaceOccluders(const FlatScene& scene, const Pose& pose, const AreaLight& light,
                                             const OccludersElsewhere& elsewhere = {});

}  // namespace halfshade
