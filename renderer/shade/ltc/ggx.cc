#include "renderer/shade/ltc/ggx.h"

#include <algorithm>
#include <cmath>

namespace halfshade {
namespace {

// Of a unit half vector, in a form that does not cancel where it is nearly the normal.
double NormalDensity(const glm::dvec3& half, double alpha) {
  const double squares = half.x * half.x + half.y * half.y + alpha * alpha * half.z * half.z;
  return alpha * alpha / (M_PI * squares * squares);
}

// cosine * sqrt(1 + alpha^2 tan^2): what Smith's functions are made of.
double SmithRoot(double cosine, double alpha) {
  return std::sqrt(cosine * cosine * (1 - alpha * alpha) + alpha * alpha);
}

double SmithOfView(double cosine, double alpha) { return 2 * cosine / (cosine + SmithRoot(cosine, alpha)); }

}  // namespace

double GgxTimesCosine(const glm::dvec3& view, const glm::dvec3& light, double alpha) {
  if (view.z <= 0 || light.z <= 0) return 0;
  const double visibility = 0.5 / (light.z * SmithRoot(view.z, alpha) + view.z * SmithRoot(light.z, alpha));
  return NormalDensity(glm::normalize(view + light), alpha) * visibility * light.z;
}

double GgxDensity(const glm::dvec3& view, const glm::dvec3& light, double alpha) {
  const glm::dvec3 half = glm::normalize(view + light);
  if (half.z <= 0) return 0;
  return SmithOfView(view.z, alpha) * NormalDensity(half, alpha) / (4 * view.z);
}

GgxSample SampleGgx(const glm::dvec3& view, double alpha, const glm::dvec2& unit) {
  // On the hemisphere that the stretched view sees, then back.
  const glm::dvec3 stretched = glm::normalize(glm::dvec3(alpha * view.x, alpha * view.y, view.z));
  const double across2 = stretched.x * stretched.x + stretched.y * stretched.y;
  const glm::dvec3 t1 =
      across2 > 0 ? glm::dvec3(-stretched.y, stretched.x, 0) / std::sqrt(across2) : glm::dvec3(1, 0, 0);
  const glm::dvec3 t2 = glm::cross(stretched, t1);
  const double radius = std::sqrt(unit.x);
  const double angle = 2 * M_PI * unit.y;
  const double a = radius * std::cos(angle);
  const double s = 0.5 * (1 + stretched.z);
  const double b = (1 - s) * std::sqrt(1 - a * a) + s * radius * std::sin(angle);
  const glm::dvec3 n = a * t1 + b * t2 + std::sqrt(std::max(0.0, 1 - a * a - b * b)) * stretched;
  const glm::dvec3 half = glm::normalize(glm::dvec3(alpha * n.x, alpha * n.y, std::max(1e-12, n.z)));
  GgxSample sample;
  const double view_on_half = glm::dot(view, half);
  sample.light = 2 * view_on_half * half - view;
  if (sample.light.z <= 0 || view_on_half <= 0) return sample;
  sample.density = GgxDensity(view, sample.light, alpha);
  sample.weight = GgxTimesCosine(view, sample.light, alpha) / sample.density;
  sample.fresnel_share = std::pow(1 - std::min(view_on_half, 1.0), 5);
  return sample;
}

}  // namespace halfshade
