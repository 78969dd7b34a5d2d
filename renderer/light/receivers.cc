#include "renderer/light/receivers.h"

#include <glad/gl.h>

#include "renderer/math/camera.h"
#include "renderer/math/light_frame.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

absl::StatusOr<gl::Texture> Upload(const gl::Context& context, const CpuReceivers& receivers,
                                   const std::vector<glm::vec4>& values) {
  ASSIGN_OR_RETURN(gl::Texture texture, gl::Texture::Create2D(context, GL_RGBA32F, receivers.width, receivers.height));
  RETURN_IF_ERROR(texture.WriteFloats(&values[0].x, 4 * values.size()));
  return texture;
}

}  // namespace

absl::StatusOr<ReceiverTextures> UploadReceivers(const gl::Context& context, const CpuReceivers& receivers) {
  ReceiverTextures textures;
  ASSIGN_OR_RETURN(textures.planes, Upload(context, receivers, receivers.planes));
  if (receivers.ArePoints()) {
    ASSIGN_OR_RETURN(textures.points, Upload(context, receivers, receivers.points));
  }
  return textures;
}

absl::StatusOr<CpuReceivers> ReadBackReceivers(const Receivers& pixels) {
  CpuReceivers receivers;
  receivers.camera = pixels.camera;
  receivers.width = pixels.width;
  receivers.height = pixels.height;
  receivers.planes.resize(size_t(pixels.width) * pixels.height);
  RETURN_IF_ERROR(pixels.planes->ReadFloats(&receivers.planes[0].x, 4 * receivers.planes.size()));
  return receivers;
}

void SetReceivers(gl::Program& program, const Receivers& receivers, const AreaLight& light) {
  const LightFrame frame = MakeLightFrame(light);
  const Camera& camera = receivers.camera;
  receivers.planes->Bind(kPlanesUnit);
  program.Set("planes", kPlanesUnit);
  if (receivers.points != nullptr) receivers.points->Bind(kPointsUnit);
  program.Set("points", receivers.points != nullptr ? kPointsUnit : kPlanesUnit);
  program.Set("are_points", int(receivers.points != nullptr));
  program.Set("ray_from_ndc", glm::mat3(RayFromNdc(camera, double(receivers.width) / receivers.height)));
  program.Set("is_orthographic", int(camera.is_orthographic));
  program.Set("ndc_from_pixel", glm::vec2(2.0 / receivers.width, 2.0 / receivers.height));
  program.Set("light_from_camera", glm::mat3(frame.light_from_world_rotation));
  program.Set("eye_in_light", glm::vec3(PointToLight(frame, camera.eye_ws)));
}

}  // namespace halfshade
