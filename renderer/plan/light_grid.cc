#include "renderer/plan/light_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "renderer/math/light_frame.h"
#include "renderer/plan/frame_plan.h"

namespace halfshade {
namespace {

constexpr double kMaxSlope = 8;
constexpr double kMargin = 1.0 / 64;  // of the window, on each side: a filter's taps stay inside
constexpr double kNearest = 1.0 / (1 << 16);

// An interval of slopes along each axis; empty: low > high.
struct Slopes {
  glm::dvec2 low{std::numeric_limits<double>::infinity()};
  glm::dvec2 high{-std::numeric_limits<double>::infinity()};
  void Add(const glm::dvec2& slope) {
    low = glm::min(low, slope);
    high = glm::max(high, slope);
  }
  bool IsEmpty() const { return low.x > high.x || low.y > high.y; }
};

// Adds the part of a box (given by its corners in the light's frame) with z >= z_near, as seen from all of
// `half_edges`.
void AddBox(const std::array<glm::dvec3, 8>& corners, double z_near, const glm::dvec2& half_edges, Slopes* slopes) {
  const auto add = [&](const glm::dvec3& p) {
    slopes->Add((glm::dvec2(p) - half_edges) / p.z);
    slopes->Add((glm::dvec2(p) + half_edges) / p.z);
  };
  for (int i = 0; i < 8; ++i) {
    if (corners[i].z >= z_near) add(corners[i]);
    for (const int axis : {1, 2, 4}) {  // an edge of the box
      const glm::dvec3 &p = corners[i], &q = corners[i ^ axis];
      if ((p.z >= z_near) == (q.z >= z_near)) continue;
      glm::dvec3 cut = glm::mix(p, q, (z_near - p.z) / (q.z - p.z));
      cut.z = z_near;
      add(cut);
    }
  }
}

std::vector<std::array<glm::dvec3, 8>> BoxesInLight(const FlatScene& scene, const Pose& pose, bool casters,
                                                    const LightFrame& frame) {
  std::vector<std::array<glm::dvec3, 8>> boxes;
  for (const Instance& instance : pose.instances) {
    if (casters && !instance.casts) continue;
    const Box3d box = WorldBox(scene, instance);
    if (box.IsEmpty()) continue;
    std::array<glm::dvec3, 8> corners;
    for (int i = 0; i < 8; ++i) {
      corners[i] = PointToLight(
          frame, {i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z});
    }
    boxes.push_back(corners);
  }
  return boxes;
}

Slopes SlopesOf(const std::vector<std::array<glm::dvec3, 8>>& boxes, const glm::dvec2& half_edges) {
  double far_z = 0;
  for (const auto& box : boxes) {
    for (const glm::dvec3& corner : box) far_z = std::max(far_z, corner.z);
  }
  Slopes slopes;
  for (const auto& box : boxes) AddBox(box, far_z * kNearest, half_edges, &slopes);
  slopes.low = glm::max(slopes.low, glm::dvec2(-kMaxSlope));
  slopes.high = glm::min(slopes.high, glm::dvec2(kMaxSlope));
  return slopes;
}

}  // namespace

Pose GridReceivers(const Pose& pose, const RenderRequest& request) {
  Pose all, sheltered;
  for (const Instance& instance : pose.instances) {
    if (!instance.receives || !instance.is_visible) continue;
    all.instances.push_back(instance);
    if (!instance.casts) sheltered.instances.push_back(instance);
  }
  return sheltered.instances.empty() && !request.ground ? all : sheltered;
}

LightGrid PlanLightGrid(const FlatScene& scene, const Pose& occluders, const Pose& receivers,
                        const RenderRequest& request, const AreaLight& light) {
  const LightFrame frame = MakeLightFrame(light);
  auto boxes = BoxesInLight(scene, receivers, false, frame);
  if (request.ground) {
    const std::array<glm::dvec3, 4> quad = GroundQuad(request);
    std::array<glm::dvec3, 8> corners;
    constexpr int kAround[4] = {0, 1, 3, 2};  // a box without height
    for (int i = 0; i < 8; ++i) corners[i] = PointToLight(frame, quad[kAround[i & 3]]);
    boxes.push_back(corners);
  }
  Slopes window = SlopesOf(boxes, glm::dvec2(0));
  // A shadow is widest where the receiver is far away: every slope under which a part of the light sees the occluder.
  const Slopes shadows = SlopesOf(BoxesInLight(scene, occluders, true, frame), {light.width_m / 2, light.height_m / 2});
  if (!shadows.IsEmpty()) {
    Slopes common;
    common.low = glm::max(window.low, shadows.low);
    common.high = glm::min(window.high, shadows.high);
    if (!common.IsEmpty()) window = common;
  }
  if (window.IsEmpty()) window.low = window.high = glm::dvec2(0);
  const glm::dvec2 middle = (window.low + window.high) / 2.0;
  const glm::dvec2 extent = (window.high - window.low) * (1 + 2 * kMargin);
  const double half = std::max({extent.x, extent.y, 1e-6}) / 2;
  LightGrid grid;
  grid.light_from_world = LightFromWorld(frame);
  grid.window = {middle - half, middle + half};
  return grid;
}

Camera CameraOf(const LightGrid& grid, const AreaLight& light, const RenderRequest& request) {
  Camera camera;
  camera.eye_ws = light.center_ws;
  camera.target_ws = request.camera.target_ws;
  camera.forward_ws = light.normal_ws;
  camera.right_ws = light.axis_u_ws;
  camera.up_ws = -light.axis_v_ws;  // row 0 is v0
  const double half = (grid.window.z - grid.window.x) / 2;
  camera.tan_half_fovy = half;
  camera.shift_ndc = {(grid.window.x + grid.window.z) / (2 * half), -(grid.window.y + grid.window.w) / (2 * half)};
  camera.near_m = kNearest * std::max(glm::length(request.camera.target_ws - light.center_ws), 1e-12);
  return camera;
}

}  // namespace halfshade
