#include "renderer/scene/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "renderer/scene/ray_fan.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

bool CountBytes(void* total, ssize_t bytes, bool) {
  *static_cast<std::atomic<int64_t>*>(total) += bytes;
  return true;
}

}  // namespace

absl::StatusOr<std::unique_ptr<RayScene>> RayScene::Create(const FlatScene& scene, const Pose& pose) {
  auto result = std::unique_ptr<RayScene>(new RayScene);
  result->AddCasters(scene, pose);
  RETURN_IF_ERROR(result->Build());
  return result;
}

RayScene::~RayScene() {
  if (scene_ != nullptr) rtcReleaseScene(scene_);
  if (device_ != nullptr) rtcReleaseDevice(device_);
}

uint64_t RayScene::SizeBytes() const {
  return triangles_.vertices.size() * sizeof(glm::vec4) + triangles_.indices.size() * sizeof(uint32_t) +
         uint64_t(std::max<int64_t>(0, embree_bytes_));
}

void RayScene::AddCasters(const FlatScene& scene, const Pose& pose) {
  std::vector<glm::dvec3> points_ws;
  Box3d bounds;
  for (const Instance& instance : pose.instances) {
    if (!instance.casts) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    const uint32_t first = uint32_t(points_ws.size());
    for (uint32_t i = 0; i < mesh.vertex_count; ++i) {
      const glm::dvec4 position(scene.positions[mesh.first_vertex + i], 1);
      points_ws.emplace_back(instance.world_from_mesh * position);
      bounds.Add(points_ws.back());
    }
    for (uint32_t i = 0; i < mesh.index_count; ++i) {
      triangles_.indices.push_back(first + scene.indices[mesh.first_index + i]);
    }
  }
  if (bounds.IsEmpty()) return;
  origin_ws_ = bounds.Center();
  const glm::dvec3 half = bounds.Extent() / 2.0;
  const double largest = std::max({half.x, half.y, half.z});
  if (largest > 0) scale_ = std::ldexp(1.0, -(std::ilogb(largest) + 1));
  triangles_.vertices.reserve(points_ws.size());
  for (const glm::dvec3& point : points_ws) triangles_.vertices.emplace_back(glm::vec3(TraceFromWorld(point)), 0);
}

absl::Status RayScene::Build() {
  if (triangles_.indices.empty()) return absl::OkStatus();
  device_ = rtcNewDevice(nullptr);
  if (device_ == nullptr) {
    return absl::InternalError("ray_scene: no Embree device, error " + std::to_string(rtcGetDeviceError(nullptr)));
  }
  rtcSetDeviceMemoryMonitorFunction(device_, &CountBytes, &embree_bytes_);
  RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, triangles_.vertices.data(), 0,
                             sizeof(glm::vec4), triangles_.vertices.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles_.indices.data(), 0,
                             3 * sizeof(uint32_t), triangles_.indices.size() / 3);
  rtcSetGeometryUserData(geometry, &triangles_);
  rtcSetGeometryOccludedFilterFunction(geometry, &LeaveOutWhatIsBelow);
  rtcCommitGeometry(geometry);
  scene_ = rtcNewScene(device_);
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(scene_, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_);
  const RTCError error = rtcGetDeviceError(device_);
  if (error == RTC_ERROR_OUT_OF_MEMORY) {
    return absl::ResourceExhaustedError("ray_scene: no memory for a hierarchy of " +
                                        std::to_string(triangles_.indices.size() / 3) + " triangles");
  }
  if (error != RTC_ERROR_NONE) return absl::InternalError("ray_scene: Embree error " + std::to_string(error));
  return absl::OkStatus();
}

}  // namespace halfshade
