#include "renderer/math/light_frame.h"

namespace halfshade {

LightFrame MakeLightFrame(const AreaLight& light) {
  return {light.center_ws, glm::transpose(glm::dmat3(light.axis_u_ws, light.axis_v_ws, light.normal_ws))};
}

AreaLight OtherSide(const AreaLight& light) {
  AreaLight other = light;
  other.axis_u_ws = -light.axis_u_ws;
  other.normal_ws = -light.normal_ws;
  return other;
}

glm::dvec3 PointToLight(const LightFrame& frame, const glm::dvec3& point_ws) {
  return frame.light_from_world_rotation * (point_ws - frame.origin_ws);
}

glm::dmat4 LightFromWorld(const LightFrame& frame) {
  glm::dmat4 matrix(frame.light_from_world_rotation);
  matrix[3] = glm::dvec4(-(frame.light_from_world_rotation * frame.origin_ws), 1);
  return matrix;
}

}  // namespace halfshade
