// Meshes whose triangles are worth keeping for every light, and where they stand before one of them. Pure; no GL.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/light/occluders.h"
#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"

namespace halfshade {

// What is not kept is copied into the frame of each light: of few triangles that is as soon done.
inline constexpr uint32_t kLeastKeptTriangles = 64;     // of a mesh
inline constexpr uint64_t kLeastTrianglesOfAll = 4096;  // of all its places
constexpr bool IsWorthKeeping(uint64_t triangles, uint64_t places) {
  return triangles >= kLeastKeptTriangles && triangles * places >= kLeastTrianglesOfAll;
}

inline constexpr uint32_t kNotKept = ~0u;

// [mesh]: the first mesh with the same triangles, whatever its material; kNotKept where it is masked, or not worth it
// at all places where the scene's nodes have it.
std::vector<uint32_t> FindKeptMeshes(const FlatScene& scene);

struct KeptPlace {
  uint32_t mesh = 0;  // the first of its like
  glm::dmat4 light_from_mesh;
  Box3f box_ls;      // of its vertices, light frame, metres, exact
  double scale = 1;  // longest axis of the mesh's unit cube, metres
};

struct KeptPlaces {
  std::vector<KeptPlace> places;  // in the order of the pose's instances
  OccludersElsewhere elsewhere;   // theirs
};

// Casting instances of kept meshes. What stands wholly behind the light's plane is in neither. What its place squeezes
// flat, or more than sixteenfold, stays with the rest: what is plane in the mesh's frame is not plane enough there.
KeptPlaces FindKeptPlaces(const FlatScene& scene, const Pose& pose, const std::vector<uint32_t>& kept_meshes,
                          const AreaLight& light);

}  // namespace halfshade
