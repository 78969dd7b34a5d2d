#include "renderer/light/cpu_receivers.h"

#include <algorithm>

#include "renderer/math/camera.h"
#include "renderer/math/horizon.h"
#include "renderer/math/light_frame.h"
#include "renderer/scene/flat_scene.h"

namespace halfshade {
namespace {

constexpr int kPointsPerRow = 1024;

// Rows of points that receive nothing yet, relative to the origin.
CpuReceivers MakeRows(size_t count) {
  CpuReceivers receivers;
  receivers.width = int(std::clamp<size_t>(count, 1, kPointsPerRow));
  receivers.height = int(std::max<size_t>(1, (count + receivers.width - 1) / receivers.width));
  const size_t size = size_t(receivers.width) * receivers.height;
  receivers.planes.assign(size, glm::vec4(0));
  receivers.points.assign(size, glm::vec4(0));
  return receivers;
}

}  // namespace

CpuReceiver CpuReceivers::At(size_t index) const {
  CpuReceiver receiver;
  receiver.is_receiving = IsReceiving(index);
  if (!receiver.is_receiving) return receiver;
  const glm::dvec4 plane(planes[index]);
  receiver.normal_ws = glm::dvec3(plane);
  receiver.offset_m = plane.w;
  if (ArePoints()) {
    receiver.position_ws = camera.eye_ws + glm::dvec3(points[index]);
    return receiver;
  }
  const size_t row = index / width;
  const double ndc_x = 2 * (double(index % width) + 0.5) / width - 1;
  const double ndc_y = 1 - 2 * (double(row) + 0.5) / height;
  const glm::dmat3 ray_from_ndc = RayFromNdc(camera, double(width) / height);
  const glm::dvec3 across = ray_from_ndc[0] * ndc_x + ray_from_ndc[1] * ndc_y;
  const glm::dvec3 origin = camera.is_orthographic ? across : glm::dvec3(0);
  const glm::dvec3 ray = camera.is_orthographic ? ray_from_ndc[2] : across + ray_from_ndc[2];
  const double along = (plane.w - glm::dot(receiver.normal_ws, origin)) / glm::dot(receiver.normal_ws, ray);
  receiver.position_ws = camera.eye_ws + origin + ray * along;
  return receiver;
}

CpuReceivers MakePointReceivers(const std::vector<glm::vec3>& points_ws, const std::vector<glm::vec3>& normals_ws) {
  CpuReceivers receivers = MakeRows(points_ws.size());
  Box3d bounds;
  for (const glm::vec3& point : points_ws) bounds.Add(glm::dvec3(point));
  if (!bounds.IsEmpty()) receivers.camera.eye_ws = bounds.Center();
  for (size_t i = 0; i < points_ws.size(); ++i) {
    const glm::dvec3 point = glm::dvec3(points_ws[i]) - receivers.camera.eye_ws;
    receivers.points[i] = glm::vec4(glm::vec3(point), 0);
    receivers.planes[i] = glm::vec4(0, 0, 0, kNoHorizon);
    if (normals_ws.empty()) continue;
    const glm::dvec3 normal = glm::normalize(glm::dvec3(normals_ws[i]));
    receivers.planes[i] = glm::vec4(glm::dvec4(normal, glm::dot(normal, point)));
  }
  return receivers;
}

CpuReceivers SelectReceivers(const CpuReceivers& pixels, const std::vector<uint32_t>& indices) {
  CpuReceivers receivers = MakeRows(indices.size());
  receivers.camera.eye_ws = pixels.camera.eye_ws;
  for (size_t i = 0; i < indices.size(); ++i) {
    const CpuReceiver pixel = pixels.At(indices[i]);
    receivers.planes[i] = pixels.planes[indices[i]];
    receivers.points[i] = glm::vec4(glm::vec3(pixel.position_ws - pixels.camera.eye_ws), 0);
  }
  return receivers;
}

LightAbovePlane CutAtPlane(const AreaLight& light, const CpuReceivers& receivers, const CpuReceiver& receiver) {
  LightAbovePlane cut;
  const glm::dvec3& normal = receiver.normal_ws;
  cut.middle = glm::dot(normal, light.center_ws - receivers.camera.eye_ws) - receiver.offset_m;
  cut.along_u = glm::dot(normal, light.axis_u_ws) * light.width_m;
  cut.along_v = glm::dot(normal, light.axis_v_ws) * light.height_m;
  const glm::dvec3 normal_ls = MakeLightFrame(light).light_from_world_rotation * normal;
  const bool is_in_front = glm::dot(receiver.position_ws - light.center_ws, light.normal_ws) > 0;
  if (is_in_front) cut.share = ShareAbovePlane({light.width_m / 2, light.height_m / 2}, normal_ls, -cut.middle);
  return cut;
}

}  // namespace halfshade
