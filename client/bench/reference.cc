#include "client/bench/reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "client/bench/shot.h"
#include "renderer/status.h"

namespace halfshade::bench {
namespace {

constexpr int kGaussianSide = 41;
constexpr double kGaussianExtent = 1.3129;
constexpr size_t kLightsAtOnce = 16;  // as many as a request takes

using Halves = std::array<Image, 2>;

v1::Method RayMethod(uint32_t rays) {
  v1::Method method;
  method.mutable_ray()->set_rays(rays);
  return method;
}

// Where something is drawn that faces part of the first light: v > 0 once nothing casts. [height][width][1], 1 or 0.
absl::StatusOr<Image> FacingMask(Client& client, const Case& bench_case, const v1::Scene& scene) {
  v1::Method hard;
  hard.mutable_hard();
  v1::RenderRequest request = VisibilityRequest(bench_case, hard, v1::CACHE_MODE_USE);
  std::map<uint32_t, v1::NodeOverride> overrides;
  for (const v1::NodeOverride& own : request.node_overrides()) overrides[own.index()] = own;
  request.clear_node_overrides();
  for (uint32_t node = 0; node < uint32_t(scene.node_names_size()); ++node) {
    v1::NodeOverride* no_shadow = request.add_node_overrides();
    *no_shadow = overrides[node];
    no_shadow->set_index(node);
    no_shadow->set_casts(false);
  }
  v1::Output* ids = request.add_outputs();
  ids->set_kind(v1::OUTPUT_KIND_OBJECT_ID);
  ids->set_encoding(v1::ENCODING_RAW_F32);
  ASSIGN_OR_RETURN(const v1::RenderResponse response, client.Render(request, nullptr));
  ASSIGN_OR_RETURN(Image mask, FirstChannel(response.images(0)));
  ASSIGN_OR_RETURN(const Image id, FirstChannel(response.images(1)));
  for (size_t i = 0; i < mask.size(); ++i) mask.data()[i] = float(mask.data()[i] > 0 && id.data()[i] > 0);
  return mask;
}

absl::StatusOr<Halves> TraceHalves(Client& client, const Case& bench_case, uint32_t rays, double* cpu_ms) {
  Halves halves;
  for (uint32_t half = 0; half < 2; ++half) {
    v1::RenderRequest request = VisibilityRequest(bench_case, RayMethod(rays / 2), v1::CACHE_MODE_USE);
    request.set_seed(bench_case.request.seed() + 1000 + half);
    ASSIGN_OR_RETURN(Shot shot, Shoot(client, request));
    halves[half] = std::move(shot.visibility);
    *cpu_ms += shot.report.timing().cpu_ms();
  }
  return halves;
}

v1::Vec3 Scaled(const v1::Vec3& v, double scale) {
  v1::Vec3 result;
  result.set_x(v.x() * scale);
  result.set_y(v.y() * scale);
  result.set_z(v.z() * scale);
  return result;
}

// A point of the light, which looks the way the light does.
v1::AreaLight PointOf(const v1::AreaLight& light, const WeighedPoint& point) {
  const v1::Vec3 u = light.edge_u(), v = light.edge_v();
  v1::AreaLight result;
  result.mutable_center()->set_x(light.center().x() + point.u * u.x() + point.v * v.x());
  result.mutable_center()->set_y(light.center().y() + point.u * u.y() + point.v * v.y());
  result.mutable_center()->set_z(light.center().z() + point.u * u.z() + point.v * v.z());
  *result.mutable_edge_u() = Scaled(u, 0);
  *result.mutable_edge_v() = Scaled(v, 0);
  if (light.has_direction()) {
    *result.mutable_direction() = light.direction();
    return result;
  }
  v1::Vec3 normal;
  normal.set_x(u.y() * v.z() - u.z() * v.y());
  normal.set_y(u.z() * v.x() - u.x() * v.z());
  normal.set_z(u.x() * v.y() - u.y() * v.x());
  *result.mutable_direction() = Scaled(normal, 1 / std::hypot(normal.x(), normal.y(), normal.z()));
  return result;
}

// A ray to each of the points; the halves are the black and the white fields of their board.
absl::StatusOr<Halves> TraceGaussian(Client& client, const Case& bench_case, double* cpu_ms) {
  const int width = int(bench_case.request.width()), height = int(bench_case.request.height());
  std::array<std::vector<double>, 2> sums;
  std::array<double, 2> weights = {0, 0};
  for (auto& sum : sums) sum.resize(size_t(width) * height);
  const std::vector<WeighedPoint> points = GaussianLights(kGaussianSide);
  for (size_t first = 0; first < points.size(); first += kLightsAtOnce) {
    const size_t count = std::min(kLightsAtOnce, points.size() - first);
    v1::RenderRequest request = VisibilityRequest(bench_case, RayMethod(1), v1::CACHE_MODE_USE);
    request.clear_lights();
    for (size_t i = 0; i < count; ++i) {
      *request.add_lights() = PointOf(bench_case.request.lights(0), points[first + i]);
    }
    ASSIGN_OR_RETURN(const v1::RenderResponse response, client.Render(request, nullptr));
    *cpu_ms += response.report().timing().cpu_ms();
    ASSIGN_OR_RETURN(const Image visibility, RawImage(response.images(0)));
    if (visibility.channels() != int(count)) return absl::InternalError("VISIBILITY has not a channel per light");
    for (size_t i = 0; i < count; ++i) {
      const size_t half = (first + i) % 2;
      weights[half] += points[first + i].weight;
      for (size_t p = 0; p < sums[half].size(); ++p) {
        sums[half][p] += points[first + i].weight * visibility.data()[p * count + i];
      }
    }
  }
  Halves halves;
  for (size_t half = 0; half < 2; ++half) {
    halves[half] = Image(width, height, 1);
    for (size_t p = 0; p < sums[half].size(); ++p) halves[half].data()[p] = float(sums[half][p] / weights[half]);
  }
  return halves;
}

}  // namespace

std::vector<WeighedPoint> GaussianLights(int side) {
  std::vector<WeighedPoint> points;
  double sum = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double u = (2.0 * x + 1) / side - 1, v = (2.0 * y + 1) / side - 1;
      points.push_back({u * kGaussianExtent / 2, v * kGaussianExtent / 2, std::exp(-2 * (u * u + v * v))});
      sum += points.back().weight;
    }
  }
  for (WeighedPoint& point : points) point.weight /= sum;
  return points;
}

absl::Status MeasureReference(Client& client, const Case& bench_case, const v1::Scene& scene, uint32_t rays,
                              CaseResult* result) {
  ASSIGN_OR_RETURN(result->mask, FacingMask(client, bench_case, scene));
  absl::StatusOr<Halves> traced = bench_case.is_gaussian
                                      ? TraceGaussian(client, bench_case, &result->reference_cpu_ms)
                                      : TraceHalves(client, bench_case, rays, &result->reference_cpu_ms);
  RETURN_IF_ERROR(traced.status());
  const Halves& halves = *traced;
  result->reference = Image(halves[0].width(), halves[0].height(), 1);
  for (size_t i = 0; i < halves[0].size(); ++i) {
    result->reference.data()[i] = (halves[0].data()[i] + halves[1].data()[i]) / 2;
  }
  ASSIGN_OR_RETURN(const ImageError between, Compare(halves[0], halves[1], &result->mask));
  result->reference_noise = between.mae_shadowed.value_or(0) / 2;
  return absl::OkStatus();
}

}  // namespace halfshade::bench
