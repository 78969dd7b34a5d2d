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

// What the filter of one fan says of a triangle.
bool HidesSomething(const RayScene::Triangles& triangles, uint32_t triangle, const glm::vec3& origin,
                    const glm::vec3& normal, float error) {
  glm::vec3 arms[3];
  for (int k = 0; k < 3; ++k) arms[k] = glm::vec3(triangles.vertices[triangles.indices[3 * triangle + k]]) - origin;
  bool is_above = normal == glm::vec3(0);
  for (int k = 0; k < 3 && !is_above; ++k) is_above = glm::dot(normal, arms[k]) > kFourUlps * Size(arms[k]) + error;
  if (!is_above) return false;
  const glm::vec3 across = glm::cross(arms[1] - arms[0], arms[2] - arms[0]);
  return std::abs(glm::dot(across, arms[0])) > (kFourUlps * Size(arms[0]) + error) * glm::length(across);
}

}  // namespace

RayFan::RayFan(const RayScene& scene, const glm::vec3& origin, const glm::vec3& normal, float error)
    : scene_(scene.embree_scene()) {
  rtcInitIntersectContext(&context_.embree);
  context_.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  context_.origin = origin;
  context_.normal = normal;
  context_.error = kFourUlps * Size(origin) + error;
  std::fill_n(is_wanted_, kSegments, -1);
  std::fill_n(rays_.org_x, kSegments, origin.x);
  std::fill_n(rays_.org_y, kSegments, origin.y);
  std::fill_n(rays_.org_z, kSegments, origin.z);
  std::fill_n(rays_.time, kSegments, 0.0f);
  std::fill_n(rays_.mask, kSegments, ~0u);
  std::fill_n(rays_.id, kSegments, 0u);
  std::fill_n(rays_.flags, kSegments, 0u);
}

int RayFan::CountOccluded() {
  if (scene_ == nullptr) return 0;
  // Where there is no plane, the receiver's own triangle is within the error at the beginning of the segments, which
  // are of about one length.
  const float length = std::max({std::abs(rays_.dir_x[0]), std::abs(rays_.dir_y[0]), std::abs(rays_.dir_z[0])});
  std::fill_n(rays_.tnear, kSegments, std::min(context_.error / length, kSegmentEnd));
  std::fill_n(rays_.tfar, kSegments, kSegmentEnd);
  rtcOccluded16(is_wanted_, scene_, &context_.embree, &rays_);
  int occluded = 0;
  for (int i = 0; i < kSegments; ++i) occluded += rays_.tfar[i] < 0;
  return occluded;
}

void LeaveOutWhatHidesNothing(const RTCFilterFunctionNArguments* args) {
  const auto& fan = *reinterpret_cast<const RayFan::Context*>(args->context);
  const auto& triangles = *static_cast<const RayScene::Triangles*>(args->geometryUserPtr);
  uint32_t last = RTC_INVALID_GEOMETRY_ID;
  bool hides = false;
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const uint32_t triangle = RTCHitN_primID(args->hit, args->N, i);
    if (triangle != last) {
      last = triangle;
      hides = HidesSomething(triangles, triangle, fan.origin, fan.normal, fan.error);
    }
    if (!hides ||
        triangles.IsMaskedAway(triangle, RTCHitN_u(args->hit, args->N, i), RTCHitN_v(args->hit, args->N, i))) {
      args->valid[i] = 0;
    }
  }
}

}  // namespace halfshade
