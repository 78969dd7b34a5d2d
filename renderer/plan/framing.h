// A camera, a light and a ground for a scene that comes without: what `halfshade render scene.glb` shows at the first
// try.
#pragma once

#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {

// Looks down from the front right, the whole box and the beginning of its shadow in view. An empty box counts as a unit
// box at the origin, a point as a small one.
Camera FrameScene(const Box3d& bounds_ws, double aspect);

// A square light above the left front, .4 of the box's diagonal wide, at 1.6 diagonals from its centre. Its irradiance
// at the box is the same whatever the size of the scene.
AreaLight SuitingLight(const Box3d& bounds_ws);

// A ground under the box, six diagonals wide.
Ground SuitingGround(const Box3d& bounds_ws);

// Near plane for a camera whose request names none: 1e-3 of the box's diagonal, nearer if the eye is inside or close.
double SuitingNearPlane(const Box3d& bounds_ws, const glm::dvec3& eye_ws);

}  // namespace halfshade
