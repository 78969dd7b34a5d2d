// Flat scenes without a loader, and the simplest meshes with closed-form shadows.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "client/glb_writer.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

// What the loader would make of WriteGlb(meshes).
FlatScene MakeFlatScene(const std::vector<GlbMesh>& meshes);

// A square of edge `size` around `center`, its normal turned from +y by `slope_rad` about the z axis. Double-sided.
GlbMesh MakeSquare(const glm::dvec3& center, double size, double slope_rad = 0);
// A rectangle parallel to the ground.
GlbMesh MakePlate(const glm::dvec3& center, double size_x, double size_z);
// An axis-aligned box, faces outward.
GlbMesh MakeBox(const glm::dvec3& center, const glm::dvec3& size);
// A sphere of `rings` x 2 `rings` quads, smooth normals.
GlbMesh MakeSphere(const glm::dvec3& center, double radius, int rings);

}  // namespace halfshade
