#include "renderer/light/window.h"

#include <algorithm>
#include <array>
#include <limits>

namespace halfshade {

OccluderHull::OccluderHull(double half_width, double half_height, double z_near) : z_near_(z_near), z_far_(z_near) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (Axis* axis : {&u_, &v_}) {
    std::fill_n(axis->low, 2, kInfinity);
    std::fill_n(axis->high, 2, -kInfinity);
  }
  u_.half = half_width;
  v_.half = half_height;
}

void OccluderHull::Axis::Add(double position, double z) {
  for (int end = 0; end < 2; ++end) {
    const double slope = (position + (end == 0 ? half : -half)) / z;
    low[end] = std::min(low[end], slope);
    high[end] = std::max(high[end], slope);
  }
}

double OccluderHull::Axis::Low(double sample) const {
  if (half == 0) return low[0];
  return glm::mix(low[0], low[1], std::clamp((sample + half) / (2 * half), 0.0, 1.0));
}

double OccluderHull::Axis::High(double sample) const {
  if (half == 0) return high[0];
  return glm::mix(high[0], high[1], std::clamp((sample + half) / (2 * half), 0.0, 1.0));
}

void OccluderHull::AddPoint(const glm::dvec3& point) {
  u_.Add(point.x, point.z);
  v_.Add(point.y, point.z);
  z_far_ = std::max(z_far_, point.z);
}

void OccluderHull::AddTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const std::array<glm::dvec3, 3> corners = {a, b, c};
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3& p = corners[i];
    const glm::dvec3& q = corners[(i + 1) % 3];
    if (p.z >= z_near_) AddPoint(p);
    if ((p.z >= z_near_) != (q.z >= z_near_)) {
      glm::dvec3 cut = glm::mix(p, q, (z_near_ - p.z) / (q.z - p.z));
      cut.z = z_near_;
      AddPoint(cut);
    }
  }
}

bool OccluderHull::NeedsSideWindows() const {
  for (const Axis* axis : {&u_, &v_}) {
    for (int end = 0; end < 2; ++end) {
      if (axis->low[end] < -kMaxWindowSlope || axis->high[end] > kMaxWindowSlope) return true;
    }
  }
  return false;
}

bool OccluderHull::ReachesSide(int side) const {
  if (side == 0) return !IsEmpty();
  if (!NeedsSideWindows()) return false;
  const Axis& axis = side <= 2 ? u_ : v_;
  return side % 2 == 1 ? std::max(axis.high[0], axis.high[1]) > kSideWindowSlope
                       : std::min(axis.low[0], axis.low[1]) < -kSideWindowSlope;
}

Window OccluderHull::FrontWindow(const glm::dvec2& sample) const {
  const double limit = FrontSlope();
  return {std::max(u_.Low(sample.x), -limit), std::max(v_.Low(sample.y), -limit), std::min(u_.High(sample.x), limit),
          std::min(v_.High(sample.y), limit)};
}

glm::dmat3 MapFromLight(int side) {
  const glm::dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  switch (side) {
    case 1:
      return glm::transpose(glm::dmat3(y, z, x));
    case 2:
      return glm::transpose(glm::dmat3(y, z, -x));
    case 3:
      return glm::transpose(glm::dmat3(x, z, y));
    case 4:
      return glm::transpose(glm::dmat3(x, z, -y));
    default:
      return glm::dmat3(1);
  }
}

}  // namespace halfshade
