#include "renderer/math/camera.h"

namespace halfshade {

absl::StatusOr<Camera> MakeLookAtCamera(const glm::dvec3& eye_ws, const glm::dvec3& target_ws,
                                        const glm::dvec3& up_ws) {
  const glm::dvec3 view = target_ws - eye_ws;
  if (glm::length(view) == 0) return absl::InvalidArgumentError("target: the same point as eye");
  Camera camera;
  camera.eye_ws = eye_ws;
  camera.target_ws = target_ws;
  camera.forward_ws = glm::normalize(view);
  const glm::dvec3 right = glm::cross(camera.forward_ws, up_ws);
  // Below a sine of 1e-6 the direction of right is noise.
  if (!(glm::length(right) > 1e-6 * glm::length(up_ws))) {
    return absl::InvalidArgumentError("up: along the view from eye to target, or zero");
  }
  camera.right_ws = glm::normalize(right);
  camera.up_ws = glm::cross(camera.right_ws, camera.forward_ws);
  return camera;
}

absl::StatusOr<Camera> CameraFromNode(const glm::dmat4& world_from_node, double target_distance_m) {
  auto camera = MakeLookAtCamera({0, 0, 0}, -glm::dvec3(world_from_node[2]), glm::dvec3(world_from_node[1]));
  if (!camera.ok()) return absl::InvalidArgumentError("the node's matrix leaves the camera no axes");
  camera->eye_ws = glm::dvec3(world_from_node[3]);
  camera->target_ws = camera->eye_ws + camera->forward_ws * target_distance_m;
  return camera;
}

Camera ShiftedCamera(Camera camera, const glm::dvec2& offset_pixels, int width, int height) {
  const glm::dvec2 shift_ndc(2 * offset_pixels.x / width, -2 * offset_pixels.y / height);
  if (camera.is_orthographic) {
    const double half_height = camera.ortho_height_m / 2;
    const double half_width = half_height * width / height;
    camera.eye_ws += camera.right_ws * (half_width * shift_ndc.x) + camera.up_ws * (half_height * shift_ndc.y);
  } else {
    camera.shift_ndc += shift_ndc;
  }
  return camera;
}

glm::dmat3 RayFromNdc(const Camera& camera, double aspect) {
  const double half_height = camera.is_orthographic ? camera.ortho_height_m / 2 : camera.tan_half_fovy;
  const glm::dvec3 right = camera.right_ws * (half_height * aspect);
  const glm::dvec3 up = camera.up_ws * half_height;
  if (camera.is_orthographic) return glm::dmat3(right, up, camera.forward_ws);
  return glm::dmat3(right, up, camera.forward_ws + right * camera.shift_ndc.x + up * camera.shift_ndc.y);
}

glm::dmat4 ClipFromView(const Camera& camera, double aspect) {
  const bool is_bounded = camera.far_m > camera.near_m;
  glm::dmat4 clip(0);
  if (camera.is_orthographic) {
    // Depth needs an end. FramePlan puts one behind everything visible; without any, a metre will do.
    const double far_m = is_bounded ? camera.far_m : camera.near_m + 1;
    clip[0][0] = 2 / (camera.ortho_height_m * aspect);
    clip[1][1] = 2 / camera.ortho_height_m;
    clip[2][2] = 1 / (far_m - camera.near_m);
    clip[3][2] = far_m / (far_m - camera.near_m);
    clip[3][3] = 1;
    return clip;
  }
  clip[0][0] = 1 / (camera.tan_half_fovy * aspect);
  clip[1][1] = 1 / camera.tan_half_fovy;
  clip[2][0] = camera.shift_ndc.x;
  clip[2][1] = camera.shift_ndc.y;
  clip[2][3] = -1;
  if (is_bounded) {
    clip[2][2] = camera.near_m / (camera.far_m - camera.near_m);
    clip[3][2] = camera.near_m * camera.far_m / (camera.far_m - camera.near_m);
  } else {
    clip[3][2] = camera.near_m;
  }
  return clip;
}

glm::dmat3 ViewRotationFromWorld(const Camera& camera) {
  return glm::transpose(glm::dmat3(camera.right_ws, camera.up_ws, -camera.forward_ws));
}

}  // namespace halfshade
