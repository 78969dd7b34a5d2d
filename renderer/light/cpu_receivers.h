// Receivers in memory: what the texture form (receivers.h) holds, for methods that resolve on the CPU, and the first
// form of points that a caller names. No GL.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "renderer/request.h"

namespace halfshade {

// Offset of a receiver that has no horizon and so no normal: every point of a light is above.
inline constexpr float kNoHorizon = -1e30f;

// One receiver.
struct CpuReceiver {
  bool is_receiving = false;
  glm::dvec3 position_ws{0};
  glm::dvec3 normal_ws{0};       // unit, on the side that gets light; 0: no horizon
  double offset_m = kNoHorizon;  // of the tangent plane from CpuReceivers::camera.eye_ws along the normal
};

struct CpuReceivers {
  // [height][width]: see Receivers::planes.
  std::vector<glm::vec4> planes;
  // Empty for pixels; else [height][width]: the receiver's position relative to camera.eye_ws, world axes.
  std::vector<glm::vec4> points;
  Camera camera;  // of points: the origin that they are relative to, and nothing else
  int width = 0;
  int height = 0;

  bool ArePoints() const { return !points.empty(); }
  size_t size() const { return planes.size(); }
  bool IsReceiving(size_t index) const {
    const glm::vec3 normal(planes[index]);
    return planes[index] != glm::vec4(0) && glm::dot(normal, normal) < 2;  // kNotReceivingScale
  }
  // Pixels: the point of the plane that the pixel's centre sees, in double.
  CpuReceiver At(size_t index) const;
};

// World points as rows of receivers; what fills up the last row does not receive. `normals`: unit, one a point, or
// empty: no horizon. Coordinates are kept to half an ulp of the distance to the middle of all points.
CpuReceivers MakePointReceivers(const std::vector<glm::vec3>& points_ws, const std::vector<glm::vec3>& normals_ws);

// Some of the receivers of a picture, as points with the same planes. Positions are kept to half an ulp of the distance
// to the eye, which the planes are told from.
CpuReceivers SelectReceivers(const CpuReceivers& pixels, const std::vector<uint32_t>& indices);

// The part of a light that a receiver's plane leaves: heights above the plane are middle + along_u a + along_v b at the
// light's point (a, b) in [-1/2, 1/2]^2 of its edges, metres.
struct LightAbovePlane {
  double middle = 0, along_u = 0, along_v = 0;
  double share = 0;  // of the light's area above the plane; 0 behind a one-sided light
  bool IsAbove(double a, double b) const { return middle + along_u * a + along_v * b > 0; }
};
LightAbovePlane CutAtPlane(const AreaLight& light, const CpuReceivers& receivers, const CpuReceiver& receiver);

}  // namespace halfshade
