// Meshes that hide a light from many places: their triangles once, and where they stand. Pure; no GL.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"

namespace halfshade {

struct SharedMesh {
  struct Place {
    glm::dmat4 light_from_mesh;
    Box3f box_ls;      // of the vertices in use, light frame, metres, exact
    double scale = 1;  // longest axis of the mesh's unit cube, metres
  };
  uint32_t mesh = 0;                 // the first of those with the same triangles
  std::vector<glm::vec3> positions;  // relative to the mesh's origin, in its order
  std::vector<uint32_t> indices;
  std::vector<Place> places;
};

struct SharedMeshes {
  std::vector<SharedMesh> meshes;
  float largest_coordinate_m = 0;  // of their boxes, light frame
  Pose rest;                       // the pose, in which what is shared does not cast
};

// Copies are drawn in two thirds of the time (renderer/shadow/shaft/README), so that only much of them is shared.
inline constexpr uint32_t kLeastSharedTriangles = 64;       // of a mesh
inline constexpr uint64_t kLeastSavedTriangles = 1u << 18;  // of all its places but one: 29 MB
constexpr bool IsWorthSharing(uint64_t triangles, uint64_t places) {
  return triangles >= kLeastSharedTriangles && places > 0 && (places - 1) * triangles >= kLeastSavedTriangles;
}

// Casting instances without a mask, by equal triangles (whatever their materials), that stand wholly in front of the
// light's plane; what stands wholly behind it is in neither. What its place squeezes flat, or more than
// sixteenfold, stays with the rest: what is plane in the mesh's frame is not plane enough there.
SharedMeshes FindSharedMeshes(const FlatScene& scene, const Pose& pose, const AreaLight& light);

}  // namespace halfshade
