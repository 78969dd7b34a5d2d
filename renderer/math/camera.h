// Cameras: from points, from glTF nodes, to projection matrices. Reversed depth: 1 at the near plane, 0 at infinity
// (GL's zero-to-one clip control).
#pragma once

#include <absl/status/statusor.h>

#include <glm/glm.hpp>

#include "renderer/request.h"

namespace halfshade {

// A camera at eye that looks at target; the extent (tan_half_fovy or ortho_height_m) and the planes are left as they
// are in Camera{}. INVALID_ARGUMENT if eye and target coincide or up is along the view: the message names the field
// ("target: ...", "up: ...").
absl::StatusOr<Camera> MakeLookAtCamera(const glm::dvec3& eye_ws, const glm::dvec3& target_ws, const glm::dvec3& up_ws);

// A glTF camera looks along its node's -z with +y up; scale in the node is ignored. target_ws is the point at
// target_distance_m ahead. INVALID_ARGUMENT where a scale of 0 leaves it no axes.
absl::StatusOr<Camera> CameraFromNode(const glm::dmat4& world_from_node, double target_distance_m);

// The same camera with its pixels' samples moved by offset_pixels (x right, y down) from their centres.
Camera ShiftedCamera(Camera camera, const glm::dvec2& offset_pixels, int width, int height);

// World axes; columns right, up, forward scaled so that (ndc.x, ndc.y, 1) gives the ray, 1 long along forward_ws
// (perspective), or, in the first two, the origin (orthographic).
glm::dmat3 RayFromNdc(const Camera& camera, double aspect);

// View space: x right, y up, -z forward. aspect = width / height.
glm::dmat4 ClipFromView(const Camera& camera, double aspect);

// World axes to view axes. Translation is not in it: subtract eye_ws in double first.
glm::dmat3 ViewRotationFromWorld(const Camera& camera);

}  // namespace halfshade
