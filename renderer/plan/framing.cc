#include "renderer/plan/framing.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/camera.h"

namespace halfshade {
namespace {

struct Sphere {
  glm::dvec3 center{0};
  double diameter = 1;
};

Sphere BoundingSphere(const Box3d& bounds) {
  if (bounds.IsEmpty()) return {};
  const double diagonal = glm::length(bounds.Extent());
  const double smallest = std::max(1e-6, 1e-6 * glm::length(bounds.Center()));
  return {bounds.Center(), std::max(diagonal, smallest)};
}

}  // namespace

Camera FrameScene(const Box3d& bounds_ws, double aspect) {
  const Sphere sphere = BoundingSphere(bounds_ws);
  const glm::dvec3 toward_eye = glm::normalize(glm::dvec3(0.55, 0.55, 1));
  // 40 degrees high; the narrower side of the picture holds the sphere and a small margin.
  const double tan_half = std::tan(20 * M_PI / 180);
  const double narrow = std::atan(tan_half * std::min(1.0, aspect));
  const double distance = 1.05 * sphere.diameter / 2 / std::sin(narrow);
  Camera camera = *MakeLookAtCamera(sphere.center + toward_eye * distance, sphere.center, {0, 1, 0});
  camera.tan_half_fovy = tan_half;
  camera.near_m = SuitingNearPlane(bounds_ws, camera.eye_ws);
  return camera;
}

AreaLight SuitingLight(const Box3d& bounds_ws) {
  const Sphere sphere = BoundingSphere(bounds_ws);
  const glm::dvec3 toward_light = glm::normalize(glm::dvec3(-0.6, 1, 0.35));
  AreaLight light;
  light.center_ws = sphere.center + toward_light * (1.6 * sphere.diameter);
  light.normal_ws = -toward_light;
  light.axis_u_ws = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), light.normal_ws));
  light.axis_v_ws = glm::cross(light.normal_ws, light.axis_u_ws);
  light.width_m = light.height_m = 0.4 * sphere.diameter;
  // A facing white surface at the box reflects about 1.
  light.radiance = glm::vec3(50);
  return light;
}

Ground SuitingGround(const Box3d& bounds_ws) {
  const Sphere sphere = BoundingSphere(bounds_ws);
  const double height = bounds_ws.IsEmpty() ? 0 : bounds_ws.min.y;
  return {height, 6 * sphere.diameter, false};
}

double SuitingNearPlane(const Box3d& bounds_ws, const glm::dvec3& eye_ws) {
  const Sphere sphere = BoundingSphere(bounds_ws);
  const double gap = glm::length(eye_ws - sphere.center) - sphere.diameter / 2;
  return std::max(1e-4 * sphere.diameter, 0.1 * gap);
}

}  // namespace halfshade
