#include "renderer/scene/ray_fan.h"

#include <algorithm>
#include <cmath>

namespace halfshade {
namespace {

constexpr float kFourUlps = 4 * 1.1920929e-7f;  // of 1
// Segments end this fraction before the light: a lamp's own surface in the light's plane does not hide it, as in every
// map (renderer/light/occluders.h: 2^-20 of the occluders' extent).
constexpr float kSegmentEnd = 1 - 9.5367432e-7f;

float Size(const glm::vec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

// What the filter of a segment says of a triangle.
bool HidesSomething(const RayScene::Triangles& triangles, uint32_t triangle, const RayOrigin& origin) {
  glm::vec3 arms[3];
  for (int k = 0; k < 3; ++k) {
    arms[k] = glm::vec3(triangles.vertices[triangles.indices[3 * triangle + k]]) - origin.point;
  }
  bool is_above = origin.normal == glm::vec3(0);
  for (int k = 0; k < 3 && !is_above; ++k) {
    is_above = glm::dot(origin.normal, arms[k]) > kFourUlps * Size(arms[k]) + origin.error;
  }
  if (!is_above) return false;
  const glm::vec3 across = glm::cross(arms[1] - arms[0], arms[2] - arms[0]);
  return std::abs(glm::dot(across, arms[0])) > (kFourUlps * Size(arms[0]) + origin.error) * glm::length(across);
}

}  // namespace

RayPacket::RayPacket(const RayScene& scene) : scene_(scene.embree_scene()) {
  rtcInitIntersectContext(&context_.embree);
  context_.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  std::fill_n(is_wanted_, kSegments, -1);
  std::fill_n(rays_.time, kSegments, 0.0f);
  std::fill_n(rays_.mask, kSegments, ~0u);
  std::fill_n(rays_.flags, kSegments, 0u);
}

void RayPacket::SetOrigin(int segment, const RayOrigin& origin, unsigned id) {
  context_.origins[id] = {origin.point, origin.normal, kFourUlps * Size(origin.point) + origin.error};
  rays_.org_x[segment] = origin.point.x;
  rays_.org_y[segment] = origin.point.y;
  rays_.org_z[segment] = origin.point.z;
  rays_.id[segment] = id;
}

void RayPacket::Trace() {
  std::fill_n(rays_.tfar, kSegments, kSegmentEnd);
  rtcOccluded16(is_wanted_, scene_, &context_.embree, &rays_);
}

RayFan::RayFan(const RayScene& scene, const RayOrigin& origin) : RayPacket(scene) {
  for (int i = 0; i < kSegments; ++i) SetOrigin(i, origin, 0);
}

int RayFan::CountOccluded() {
  if (scene_ == nullptr) return 0;
  // Where there is no plane, the receiver's own triangle is within the error at the beginning of the segments.
  const float length = std::max({std::abs(rays_.dir_x[0]), std::abs(rays_.dir_y[0]), std::abs(rays_.dir_z[0])});
  std::fill_n(rays_.tnear, kSegments, std::min(context_.origins[0].error / length, kSegmentEnd));
  Trace();
  int occluded = 0;
  for (int i = 0; i < kSegments; ++i) occluded += rays_.tfar[i] < 0;
  return occluded;
}

uint32_t RayBundle::FindOccluded() {
  if (scene_ == nullptr) return 0;
  for (int i = 0; i < kSegments; ++i) {
    if (is_wanted_[i] == 0) continue;
    const float length = std::max({std::abs(rays_.dir_x[i]), std::abs(rays_.dir_y[i]), std::abs(rays_.dir_z[i])});
    rays_.tnear[i] = std::min(context_.origins[i].error / length, kSegmentEnd);
  }
  Trace();
  uint32_t occluded = 0;
  for (int i = 0; i < kSegments; ++i) occluded |= uint32_t(is_wanted_[i] != 0 && rays_.tfar[i] < 0) << i;
  return occluded;
}

void LeaveOutWhatHidesNothing(const RTCFilterFunctionNArguments* args) {
  const RayOrigin* origins = reinterpret_cast<const RayPacket::Context*>(args->context)->origins;
  const auto& triangles = *static_cast<const RayScene::Triangles*>(args->geometryUserPtr);
  uint32_t last = RTC_INVALID_GEOMETRY_ID, last_id = 0;
  bool hides = false;
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const uint32_t triangle = RTCHitN_primID(args->hit, args->N, i);
    const uint32_t id = RTCRayN_id(args->ray, args->N, i);
    if (triangle != last || id != last_id) {
      last = triangle;
      last_id = id;
      hides = HidesSomething(triangles, triangle, origins[id]);
    }
    if (!hides ||
        triangles.IsMaskedAway(triangle, RTCHitN_u(args->hit, args->N, i), RTCHitN_v(args->hit, args->N, i))) {
      args->valid[i] = 0;
    }
  }
}

}  // namespace halfshade
