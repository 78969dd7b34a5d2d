#include <cmath>

#include "renderer/math/camera.h"
#include "renderer/plan/framing.h"
#include "renderer/scene/pose.h"
#include "renderer/status.h"
#include "server/validate_field.h"

namespace halfshade {
namespace {

constexpr double kDefaultFovyDeg = 45;
constexpr double kSmallestFovyDeg = 1e-15;  // below, 1 / tan is no float
constexpr char kLookAt[] = "camera.look_at";

// MakeLookAtCamera's faults, with the path of the field in front.
absl::StatusOr<Camera> LookAtCamera(const v1::LookAt& look_at) {
  if (!look_at.has_eye()) return FieldError(std::string(kLookAt) + ".eye", "missing");
  if (!look_at.has_target()) return FieldError(std::string(kLookAt) + ".target", "missing");
  ASSIGN_OR_RETURN(const glm::dvec3 eye, CheckVec3(std::string(kLookAt) + ".eye", look_at.eye()));
  ASSIGN_OR_RETURN(const glm::dvec3 target, CheckVec3(std::string(kLookAt) + ".target", look_at.target()));
  glm::dvec3 up(0, 1, 0);
  if (look_at.has_up()) {
    ASSIGN_OR_RETURN(up, CheckVec3(std::string(kLookAt) + ".up", look_at.up()));
    if (LengthOf(up) > 0) up = UnitOf(up);
  }
  if (LengthOf(target - eye) < kSmallestLengthM) {
    return FieldError(std::string(kLookAt) + ".target", "the same point as eye");
  }
  auto camera = MakeLookAtCamera(eye, target, up);
  if (!camera.ok())
    return absl::InvalidArgumentError(std::string(kLookAt) + "." + std::string(camera.status().message()));
  double fovy_deg = kDefaultFovyDeg;
  if (look_at.has_fovy_deg()) {
    fovy_deg = look_at.fovy_deg();
    if (!(fovy_deg >= kSmallestFovyDeg && fovy_deg < 180)) {
      return FieldError(std::string(kLookAt) + ".fovy_deg",
                        NumberText(fovy_deg) + "; must be at least 1e-15 and under 180");
    }
  }
  camera->tan_half_fovy = std::tan(fovy_deg * M_PI / 360);
  if (look_at.has_ortho_height_m()) {
    RETURN_IF_ERROR(CheckLength(std::string(kLookAt) + ".ortho_height_m", look_at.ortho_height_m()));
    camera->is_orthographic = true;
    camera->ortho_height_m = look_at.ortho_height_m();
  }
  if (look_at.has_near_m()) RETURN_IF_ERROR(CheckLength(std::string(kLookAt) + ".near_m", look_at.near_m()));
  if (look_at.has_far_m()) {
    RETURN_IF_ERROR(CheckLength(std::string(kLookAt) + ".far_m", look_at.far_m()));
    if (look_at.has_near_m() && look_at.far_m() <= look_at.near_m()) {
      return FieldError(std::string(kLookAt) + ".far_m",
                        NumberText(look_at.far_m()) + "; must be over near_m (" + NumberText(look_at.near_m()) + ")");
    }
  }
  return camera;
}

// A file may say what no request may.
absl::Status CheckSceneCamera(const std::string& field, const Camera& camera, double fovy_rad) {
  for (int i = 0; i < 3; ++i) {
    RETURN_IF_ERROR(CheckRange(field + "eye." + "xyz"[i], camera.eye_ws[i], -kLargestLengthM, kLargestLengthM));
  }
  if (camera.is_orthographic) {
    RETURN_IF_ERROR(CheckLength(field + "ymag", camera.ortho_height_m / 2));
  } else {
    RETURN_IF_ERROR(CheckRange(field + "yfov", fovy_rad, kSmallestFovyDeg * M_PI / 180, M_PI));
  }
  // An orthographic camera may begin at its eye, a perspective one may end nowhere.
  if (camera.near_m != 0 || !camera.is_orthographic) RETURN_IF_ERROR(CheckLength(field + "znear", camera.near_m));
  if (camera.far_m != 0 || camera.is_orthographic) RETURN_IF_ERROR(CheckLength(field + "zfar", camera.far_m));
  return absl::OkStatus();
}

absl::StatusOr<Camera> SceneCameraOf(uint32_t index, const FlatScene& scene, const std::vector<NodeOverride>& overrides,
                                     const Box3d& bounds_ws) {
  if (index >= scene.cameras.size()) {
    return FieldError("camera.index",
                      std::to_string(index) + "; the scene has " + std::to_string(scene.cameras.size()));
  }
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
    if (scene.nodes[node].camera != int32_t(index)) continue;
    const glm::dmat4 world_from_node = WorldFromNode(scene, node, overrides);
    const glm::dvec3 eye(world_from_node[3]);
    const glm::dvec3 center = bounds_ws.IsEmpty() ? glm::dvec3(0) : bounds_ws.Center();
    auto camera = CameraFromNode(world_from_node, std::max(1e-6, glm::length(center - eye)));
    if (!camera.ok()) {
      return FieldError("camera.index", std::to_string(index) + "; " + std::string(camera.status().message()));
    }
    const SceneCamera& source = scene.cameras[index];
    camera->is_orthographic = source.is_orthographic;
    camera->ortho_height_m = source.ortho_height_m;
    camera->tan_half_fovy = std::tan(source.fovy_rad / 2);
    camera->near_m = source.near_m;
    camera->far_m = source.far_m;
    RETURN_IF_ERROR(CheckSceneCamera("camera.index: " + std::to_string(index) + "; ", *camera, source.fovy_rad));
    return camera;
  }
  return FieldError("camera.index", std::to_string(index) + "; no node of the scene holds this camera");
}

}  // namespace

absl::Status CheckCameraFields(const v1::Camera& camera) {
  if (camera.has_look_at()) return LookAtCamera(camera.look_at()).status();
  return absl::OkStatus();
}

absl::StatusOr<Camera> ResolveCamera(const v1::RenderRequest& request, const FlatScene& scene,
                                     const std::vector<NodeOverride>& overrides, const Box3d& bounds_ws,
                                     double aspect) {
  Camera camera;
  if (request.camera().has_index()) {
    ASSIGN_OR_RETURN(camera, SceneCameraOf(request.camera().index(), scene, overrides, bounds_ws));
    return camera;  // glTF gives near planes: > 0, orthographic >= 0
  }
  if (!request.camera().has_look_at()) return FrameScene(bounds_ws, aspect);
  const v1::LookAt& look_at = request.camera().look_at();
  ASSIGN_OR_RETURN(camera, LookAtCamera(look_at));
  // An orthographic view begins at the eye: nothing is divided by its distance.
  camera.near_m = look_at.has_near_m()     ? look_at.near_m()
                  : camera.is_orthographic ? 0
                                           : SuitingNearPlane(bounds_ws, camera.eye_ws);
  if (look_at.has_far_m()) {
    camera.far_m = look_at.far_m();
    camera.near_m = std::min(camera.near_m, camera.far_m / 2);
  }
  return camera;
}

}  // namespace halfshade
