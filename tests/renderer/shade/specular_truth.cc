#include "tests/renderer/shade/specular_truth.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "renderer/shade/ltc/ggx.h"
#include "renderer/shade/ltc/ltc_table.h"

namespace halfshade {
namespace {

// Rows: the surface frame's axes, the view in the half plane x > 0, y = 0.
glm::dmat3 SurfaceFromLight(const SurfacePoint& point) {
  const glm::dvec3 n = point.normal;
  glm::dvec3 x = point.view - n * glm::dot(point.view, n);
  if (glm::length(x) < 1e-9) x = glm::cross(n, std::abs(n.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0));
  x = glm::normalize(x);
  return glm::transpose(glm::dmat3(x, glm::cross(n, x), n));
}

double Alpha(const SurfacePoint& point) {
  const double roughness = std::max(point.roughness, kMinLtcRoughness);
  return roughness * roughness;
}

std::vector<glm::dvec3> Clip(const std::vector<glm::dvec3>& polygon, const glm::dvec3& above) {
  std::vector<glm::dvec3> result;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec3 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    const double height_a = glm::dot(a, above), height_b = glm::dot(b, above);
    if (height_a > 0) result.push_back(a);
    if ((height_a > 0) != (height_b > 0)) result.push_back(a + (b - a) * (height_a / (height_a - height_b)));
  }
  return result;
}

}  // namespace

double SpecularByTable(const glm::dvec2& half_edges, const SurfacePoint& point) {
  if (point.position.z <= 0) return 0;
  const LtcEntry entry = InterpolateLtc(point.roughness, glm::dot(point.normal, point.view));
  const glm::dmat3 surface = SurfaceFromLight(point);
  const glm::dmat3 inverse(entry.m11, 0, entry.m31, 0, 1, 0, entry.m13, 0, entry.m33);
  std::vector<glm::dvec3> polygon;
  for (const glm::dvec2 sign : {glm::dvec2(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
    polygon.push_back(surface * (glm::dvec3(half_edges * sign, 0) - point.position));
  }
  polygon = Clip(polygon, {0, 0, 1});
  for (glm::dvec3& p : polygon) p = inverse * p;
  polygon = Clip(polygon, {0, 0, 1});
  double sum = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec3 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    const glm::dvec3 across = glm::cross(a, b - a);
    const double size = glm::length(across);
    if (size > 0) sum += across.z / size * std::atan2(size, glm::dot(a, b));
  }
  return SpecularAlbedo(entry, point.f0) * std::abs(sum) / (2 * M_PI) / LtcShareAbove(entry);
}

double SpecularByIntegration(const glm::dvec2& half_edges, const SurfacePoint& point, int n) {
  const glm::dmat3 surface = SurfaceFromLight(point);
  const glm::dmat3 light_from_surface = glm::transpose(surface);
  const glm::dvec3 view = surface * point.view;
  double sum = 0;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const GgxSample sample = SampleGgx(view, Alpha(point), {(x + 0.5) / n, (y + 0.5) / n});
      const glm::dvec3 ray = light_from_surface * sample.light;
      if (sample.weight == 0 || ray.z >= 0) continue;
      const glm::dvec3 hit = point.position - ray * (point.position.z / ray.z);
      if (std::abs(hit.x) > half_edges.x || std::abs(hit.y) > half_edges.y) continue;
      sum += sample.weight * (point.f0 + (1 - point.f0) * sample.fresnel_share);
    }
  }
  return sum / (double(n) * n);
}

double SpecularOfPoint(const SurfacePoint& point) {
  const glm::dvec3 light = -glm::normalize(point.position);
  const double fresnel =
      point.f0 + (1 - point.f0) * std::pow(1 - glm::dot(glm::normalize(light + point.view), light), 5);
  const double distance2 = glm::dot(point.position, point.position);
  const glm::dmat3 surface = SurfaceFromLight(point);
  return fresnel * GgxTimesCosine(surface * point.view, surface * light, Alpha(point)) * std::max(0.0, -light.z) /
         distance2;
}

}  // namespace halfshade
