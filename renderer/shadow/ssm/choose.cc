#include "renderer/shadow/ssm/choose.h"

#include <algorithm>
#include <cmath>

namespace halfshade {
namespace {

constexpr int kMostSubLights = 4;
constexpr double kWideFootprint = 0.2;  // of the window: from here on as many sub-lights as there may be
constexpr double kPatchesInFootprint = 16;
constexpr int kLeastMapSize = 256, kMostMapSize = 512;  // of 128 the half patch at straight edges is the largest error
constexpr int kMapSizeStep = 64;

double FootprintShare(double edge_m, double window, double z_near) {
  return edge_m > 0 && window > 0 ? edge_m / z_near / window : 0;
}

}  // namespace

SsmChoice ChooseSsm(const SsmOptions& options, const AreaLight& light, const OccluderHull& hull) {
  const Window window = hull.FrontWindow(glm::dvec2(0));
  const double share = std::max(FootprintShare(light.width_m, window.u1 - window.u0, hull.z_near()),
                                FootprintShare(light.height_m, window.v1 - window.v0, hull.z_near()));
  const double wide = std::min(share / kWideFootprint, 1.0);
  SsmChoice choice;
  choice.sub_lights =
      options.sub_lights > 0 ? options.sub_lights : std::max(1, int(std::ceil(kMostSubLights * std::sqrt(wide))));
  // In a room z_near is what was clipped at the light's plane: no footprint is as wide as it says.
  const bool is_known = share > 0 && !hull.NeedsSideWindows();
  const double needed = is_known ? kPatchesInFootprint * choice.sub_lights / share : kMostMapSize;
  const int steps = int(std::ceil(std::min<double>(needed, kMostMapSize) / kMapSizeStep));
  choice.map_size =
      options.occluder_map_size > 0 ? options.occluder_map_size : std::max(kLeastMapSize, steps * kMapSizeStep);
  return choice;
}

}  // namespace halfshade
