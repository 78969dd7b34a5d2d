#include "renderer/light/receiver_tile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/math/camera.h"
#include "renderer/math/light_frame.h"

namespace halfshade {

ReceiverTiles::ReceiverTiles(const CpuReceivers& receivers, const AreaLight& light)
    : receivers_(receivers),
      columns_((receivers.width + ReceiverTile::kSide - 1) / ReceiverTile::kSide),
      rows_((receivers.height + ReceiverTile::kSide - 1) / ReceiverTile::kSide) {
  const LightFrame frame = MakeLightFrame(light);
  light_from_world_ = frame.light_from_world_rotation;
  eye_ls_ = PointToLight(frame, receivers.camera.eye_ws);
  half_edges_ = {light.width_m / 2, light.height_m / 2};
  ray_from_ndc_ = light_from_world_ * RayFromNdc(receivers.camera, double(receivers.width) / receivers.height);
}

void ReceiverTiles::Fill(int tile, ReceiverTile* result) const {
  ReceiverTile& t = *result;
  t.count = 0;
  const int left = tile % columns_ * ReceiverTile::kSide;
  const int top = tile / columns_ * ReceiverTile::kSide;
  const Camera& camera = receivers_.camera;
  for (int y = top; y < std::min(top + ReceiverTile::kSide, receivers_.height); ++y) {
    const double ndc_y = 1 - 2 * (y + 0.5) / receivers_.height;
    for (int x = left; x < std::min(left + ReceiverTile::kSide, receivers_.width); ++x) {
      const size_t index = size_t(y) * receivers_.width + x;
      if (!receivers_.IsReceiving(index)) continue;
      const glm::dvec4 plane(receivers_.planes[index]);
      const glm::dvec3 normal = light_from_world_ * glm::dvec3(plane);
      glm::dvec3 position;
      if (receivers_.ArePoints()) {
        position = light_from_world_ * glm::dvec3(receivers_.points[index]);
      } else {
        const double ndc_x = 2 * (x + 0.5) / receivers_.width - 1;
        const glm::dvec3 across = ray_from_ndc_[0] * ndc_x + ray_from_ndc_[1] * ndc_y;
        const glm::dvec3 origin = camera.is_orthographic ? across : glm::dvec3(0);
        const glm::dvec3 ray = camera.is_orthographic ? ray_from_ndc_[2] : across + ray_from_ndc_[2];
        position = origin + ray * ((plane.w - glm::dot(normal, origin)) / glm::dot(normal, ray));
      }
      position += eye_ls_;
      if (!(position.z > 0)) continue;
      const int i = t.count++;
      t.index[i] = uint32_t(index);
      t.w[i] = 1 / position.z;
      t.u[i] = position.x / position.z;
      t.v[i] = position.y / position.z;
      t.normal_x[i] = float(normal.x);
      t.normal_y[i] = float(normal.y);
      t.normal_z[i] = float(normal.z);
      t.height[i] = float(-(plane.w + glm::dot(normal, eye_ls_)));
      constexpr double kFourUlps = 4 * 1.1920929e-7;
      t.error[i] = float(kFourUlps * (glm::length(position) + glm::length(eye_ls_)));
    }
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  t.slope_low = glm::dvec2(kInfinity);
  t.slope_high = glm::dvec2(-kInfinity);
  t.w_low = kInfinity;
  t.w_high = 0;
  t.shares_plane = t.sees_whole_light = true;
  for (int i = 0; i < t.count; ++i) {
    t.slope_low = glm::min(t.slope_low, glm::dvec2(t.u[i], t.v[i]));
    t.slope_high = glm::max(t.slope_high, glm::dvec2(t.u[i], t.v[i]));
    t.w_low = std::min(t.w_low, t.w[i]);
    t.w_high = std::max(t.w_high, t.w[i]);
    t.shares_plane = t.shares_plane && t.normal_x[i] == t.normal_x[0] && t.normal_y[i] == t.normal_y[0] &&
                     t.normal_z[i] == t.normal_z[0] && t.height[i] == t.height[0];
    const float reach = std::abs(t.normal_x[i]) * half_edges_.x + std::abs(t.normal_y[i]) * half_edges_.y;
    t.sees_whole_light = t.sees_whole_light && t.height[i] > reach;
  }
}

}  // namespace halfshade
