#include "renderer/scene/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <string>

#include "renderer/scene/ray_fan.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

bool CountBytes(void* total, ssize_t bytes, bool) {
  *static_cast<std::atomic<int64_t>*>(total) += bytes;
  return true;
}

// What Embree asks while it builds, from the threads that do. The first error stands: a check that failed once may hold
// again, and by then a part of the hierarchy is missing.
struct BuildStop {
  const StopCheck& check;
  std::mutex mutex;
  absl::Status status;

  static bool GoesOn(void* self, double) {
    auto& stop = *static_cast<BuildStop*>(self);
    const std::lock_guard lock(stop.mutex);
    if (stop.status.ok()) stop.status = stop.check();
    return stop.status.ok();
  }
};

// Of every corner of the mesh's triangles: texture coordinate of the base colour, and alpha.
void AddMaskCorners(const FlatScene& scene, const Mesh& mesh, std::vector<glm::vec3>* corners) {
  const Material& material = scene.materials[mesh.material];
  const auto& texcoords = material.base_color_texture.texcoord == 1 ? scene.texcoords1 : scene.texcoords;
  for (uint32_t i = 0; i < mesh.index_count; ++i) {
    const uint32_t vertex = mesh.first_vertex + scene.indices[mesh.first_index + i];
    const glm::vec2 texcoord = texcoords.empty() ? glm::vec2(0) : texcoords[vertex];
    const float alpha = scene.colors.empty() ? 1 : scene.colors[vertex].a;
    corners->emplace_back(texcoord, alpha * material.base_color.a);
  }
}

void AddBlendCorners(const FlatScene& scene, const Mesh& mesh, const BlendSpace& space,
                     std::vector<glm::vec3>* corners) {
  for (uint32_t i = 0; i < mesh.index_count; ++i) {
    corners->push_back(space.Place(scene.positions[mesh.first_vertex + scene.indices[mesh.first_index + i]]));
  }
}

}  // namespace

bool RayScene::Triangles::IsMaskedAway(uint32_t triangle, float u, float v) const {
  if (triangle < first_masked) return false;
  const uint32_t masked = triangle - first_masked;
  const glm::vec3* corner = &mask_corners[size_t{3} * masked];
  const glm::vec3 here = corner[0] * (1 - u - v) + corner[1] * u + corner[2] * v;
  const RayMask& mask = masks[mask_of_triangle[masked]];
  if (!mask.is_blend()) return mask.IsMaskedAway(here, here.z);
  const glm::vec3* place = &blend_corners[size_t{3} * masked];
  return mask.IsMaskedAway(here, here.z, place[0] * (1 - u - v) + place[1] * u + place[2] * v);
}

absl::StatusOr<std::unique_ptr<RayScene>> RayScene::Create(const FlatScene& scene, const Pose& pose,
                                                           const ImageDecoder& decoder, const StopCheck& stop) {
  auto result = std::unique_ptr<RayScene>(new RayScene);
  RETURN_IF_ERROR(result->AddCasters(scene, pose, decoder));
  RETURN_IF_ERROR(stop());
  RETURN_IF_ERROR(result->Build(stop));
  return result;
}

RayScene::~RayScene() {
  if (scene_ != nullptr) rtcReleaseScene(scene_);
  if (device_ != nullptr) rtcReleaseDevice(device_);
}

uint64_t RayScene::SizeBytes() const {
  uint64_t bytes = triangles_.vertices.size() * sizeof(glm::vec4) +
                   (triangles_.indices.size() + triangles_.mask_of_triangle.size()) * sizeof(uint32_t) +
                   (triangles_.mask_corners.size() + triangles_.blend_corners.size()) * sizeof(glm::vec3) +
                   boxes_.SizeBytes();
  for (const RayMask& mask : triangles_.masks) bytes += mask.SizeBytes();
  return bytes + uint64_t(std::max<int64_t>(0, embree_bytes_));
}

absl::Status RayScene::AddCasters(const FlatScene& scene, const Pose& pose, const ImageDecoder& decoder) {
  std::vector<glm::dvec3> points_ws;
  Box3d bounds;
  std::map<uint32_t, uint32_t> mask_of_material;
  const bool has_blend = HasBlendCaster(scene, pose);
  size_t vertex_count = 0, index_count = 0;  // what grows as it comes holds twice as much in the end
  for (const Instance& instance : pose.instances) {
    if (!instance.casts) continue;
    vertex_count += scene.meshes[instance.mesh].vertex_count;
    index_count += scene.meshes[instance.mesh].index_count;
  }
  points_ws.reserve(vertex_count);
  triangles_.indices.reserve(index_count);
  for (const MaskCoverage coverage : {MaskCoverage::kFull, MaskCoverage::kTested}) {
    if (coverage == MaskCoverage::kTested) triangles_.first_masked = uint32_t(triangles_.indices.size() / 3);
    for (const Instance& instance : pose.instances) {
      const Mesh& mesh = scene.meshes[instance.mesh];
      if (!instance.casts || scene.CoverageOf(mesh) != coverage) continue;
      const uint32_t first = uint32_t(points_ws.size());
      for (uint32_t i = 0; i < mesh.vertex_count; ++i) {
        const glm::dvec4 position(scene.positions[mesh.first_vertex + i], 1);
        points_ws.emplace_back(instance.world_from_mesh * position);
        bounds.Add(points_ws.back());
      }
      for (uint32_t i = 0; i < mesh.index_count; ++i) {
        triangles_.indices.push_back(first + scene.indices[mesh.first_index + i]);
      }
      if (coverage == MaskCoverage::kFull) continue;
      const auto [mask, is_new] = mask_of_material.try_emplace(mesh.material, uint32_t(triangles_.masks.size()));
      if (is_new) {
        ASSIGN_OR_RETURN(RayMask made, MakeRayMask(scene, scene.materials[mesh.material], decoder));
        triangles_.masks.push_back(std::move(made));
      }
      triangles_.mask_of_triangle.insert(triangles_.mask_of_triangle.end(), mesh.TriangleCount(), mask->second);
      AddMaskCorners(scene, mesh, &triangles_.mask_corners);
      if (has_blend) AddBlendCorners(scene, mesh, BlendSpace(mesh, instance), &triangles_.blend_corners);
    }
  }
  if (bounds.IsEmpty()) return absl::OkStatus();
  origin_ws_ = bounds.Center();
  const glm::dvec3 half = bounds.Extent() / 2.0;
  const double largest = std::max({half.x, half.y, half.z});
  if (largest > 0) scale_ = std::ldexp(1.0, -(std::ilogb(largest) + 1));
  triangles_.vertices.reserve(points_ws.size());
  for (const glm::dvec3& point : points_ws) triangles_.vertices.emplace_back(glm::vec3(TraceFromWorld(point)), 0);
  boxes_ = RayBoxes(triangles_.vertices, triangles_.indices);
  return absl::OkStatus();
}

absl::Status RayScene::Build(const StopCheck& stop) {
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
  rtcSetGeometryOccludedFilterFunction(geometry, &LeaveOutWhatHidesNothing);
  rtcCommitGeometry(geometry);
  scene_ = rtcNewScene(device_);
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(scene_, geometry);
  rtcReleaseGeometry(geometry);
  BuildStop build_stop{stop, {}, {}};
  rtcSetSceneProgressMonitorFunction(scene_, &BuildStop::GoesOn, &build_stop);
  rtcCommitScene(scene_);
  rtcSetSceneProgressMonitorFunction(scene_, nullptr, nullptr);
  RETURN_IF_ERROR(build_stop.status);
  const RTCError error = rtcGetDeviceError(device_);
  if (error == RTC_ERROR_OUT_OF_MEMORY) {
    return absl::ResourceExhaustedError("ray_scene: no memory for a hierarchy of " +
                                        std::to_string(triangles_.indices.size() / 3) + " triangles");
  }
  if (error != RTC_ERROR_NONE) return absl::InternalError("ray_scene: Embree error " + std::to_string(error));
  return absl::OkStatus();
}

}  // namespace halfshade
