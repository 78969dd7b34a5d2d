#include "renderer/light/receivers.h"

#include "renderer/math/camera.h"
#include "renderer/math/light_frame.h"

namespace halfshade {

void SetReceivers(gl::Program& program, const Receivers& receivers, const AreaLight& light) {
  const LightFrame frame = MakeLightFrame(light);
  const Camera& camera = receivers.camera;
  receivers.planes->Bind(kPlanesUnit);
  program.Set("planes", kPlanesUnit);
  program.Set("ray_from_ndc", glm::mat3(RayFromNdc(camera, double(receivers.width) / receivers.height)));
  program.Set("is_orthographic", int(camera.is_orthographic));
  program.Set("ndc_from_pixel", glm::vec2(2.0 / receivers.width, 2.0 / receivers.height));
  program.Set("light_from_camera", glm::mat3(frame.light_from_world_rotation));
  program.Set("eye_in_light", glm::vec3(PointToLight(frame, camera.eye_ws)));
}

}  // namespace halfshade
