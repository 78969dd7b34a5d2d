#include "renderer/light/lit_receivers.h"

#include <algorithm>
#include <limits>

#include "renderer/light/light_shaft.h"
#include "renderer/light/parallel_for.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr int kTile = 16;
constexpr size_t kRun = kTile * kTile;  // receivers that are found lit together: of a tile, where all receive

LightShaft ShaftOf(const RayScene& scene, const AreaLight& light, const CpuReceivers& receivers, const uint32_t* run,
                   size_t count) {
  Box3d box;
  double error = std::numeric_limits<double>::infinity();  // as that of RayFan, but for the occluder's own
  bool shares_plane = !receivers.ArePoints();
  for (size_t i = 0; i < count; ++i) {
    const CpuReceiver receiver = receivers.At(run[i]);
    const glm::vec3 origin(scene.TraceFromWorld(receiver.position_ws));
    box.Add(glm::dvec3(origin));
    error = std::min(error, PlaneError(scene, receivers, receiver));
    shares_plane = shares_plane && receivers.planes[run[i]] == receivers.planes[run[0]];
  }
  const glm::dvec3 center = scene.TraceFromWorld(light.center_ws);
  const glm::dvec3 u(glm::vec3(light.axis_u_ws * (light.width_m * scene.trace_scale())) / 2.0f);
  const glm::dvec3 v(glm::vec3(light.axis_v_ws * (light.height_m * scene.trace_scale())) / 2.0f);
  LightShaft shaft({center - u - v, center + u - v, center - u + v, center + u + v}, box);
  // What does not rise above their plane by half of what RayFan allows for is left out by it, whatever is rounded.
  const CpuReceiver receiver = receivers.At(run[0]);
  if (shares_plane && receiver.normal_ws != glm::dvec3(0)) {
    shaft.CutBelow(receiver.normal_ws,
                   glm::dot(receiver.normal_ws, scene.TraceFromWorld(receiver.position_ws)) + error / 2);
  }
  return shaft;
}

}  // namespace

std::vector<uint32_t> ReceiversInTiles(const CpuReceivers& receivers) {
  std::vector<uint32_t> order;
  order.reserve(receivers.size());
  const int tile_width = receivers.ArePoints() ? receivers.width : kTile;
  for (int top = 0; top < receivers.height; top += kTile) {
    for (int left = 0; left < receivers.width; left += tile_width) {
      for (int y = top; y < std::min(top + kTile, receivers.height); ++y) {
        for (int x = left; x < std::min(left + tile_width, receivers.width); ++x) {
          const uint32_t index = uint32_t(y) * receivers.width + x;
          if (receivers.IsReceiving(index)) order.push_back(index);
        }
      }
    }
  }
  return order;
}

double PlaneError(const RayScene& scene, const CpuReceivers& receivers, const CpuReceiver& receiver) {
  constexpr double kFourUlps = 4.8e-7;
  return kFourUlps * glm::length(receiver.position_ws - receivers.camera.eye_ws) * scene.trace_scale();
}

absl::StatusOr<std::vector<uint8_t>> FindLit(const RayScene& scene, const AreaLight& light,
                                             const CpuReceivers& receivers, const std::vector<uint32_t>& order,
                                             const std::function<absl::Status()>& stop, int threads) {
  std::vector<uint8_t> is_lit(receivers.size());
  const auto find = [&](int run) {
    const size_t first = size_t(run) * kRun, last = std::min(order.size(), first + kRun);
    const LightShaft shaft = ShaftOf(scene, light, receivers, &order[first], last - first);
    if (!scene.boxes().AreAllOutside([&](const Box3f& box) { return shaft.Misses(box); })) return;
    for (size_t i = first; i < last; ++i) is_lit[order[i]] = 1;
  };
  RETURN_IF_ERROR(ParallelFor(int((order.size() + kRun - 1) / kRun), 1, find, stop, threads));
  return is_lit;
}

}  // namespace halfshade
