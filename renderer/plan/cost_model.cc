#include "renderer/plan/cost_model.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "renderer/light/kept_meshes.h"
#include "renderer/math/light_frame.h"
#include "renderer/plan/frame_plan.h"

namespace halfshade {
namespace {

constexpr double kEach = 1.5;  // whatever its size: what a picture of one pixel takes
constexpr double kPrimaryPerReceiver = 4e-5;
constexpr double kFinishPerReceiver = 8e-5;  // of maps' methods: horizon, clamping, read-back; a light
constexpr double kShaftPerTriangle = 8e-4;
constexpr double kShaftPerKept = 2e-3;  // once a scene: the mesh's levels and its shape
constexpr double kShaftPerReceiver = 8e-5;
constexpr double kShaftPerPolygon = 8.7e-6, kShaftGrowth = 0.25;  // times triangles^.25: what a tile's list grows like
constexpr double kShaftCluttered = 1.75;                          // times that where no triangle shares a vertex
constexpr double kShaftPerListed = 1e-4;                          // of a polygon in a block's list, at 8 rows
constexpr double kShaftPerRow = 1.0 / 50;                         // of that, for each row beyond 8
constexpr double kShaftMasked = 16;                               // times as dear at 8 rows where all is masked
constexpr double kMaskedPerRow = 1.0 / 11;                        // of that, for each row beyond 8
constexpr double kShaftSparse = 0.8;
constexpr double kRayPerTriangle = 5e-4;
constexpr double kRayPerRay = 1.6e-6;  // times the logarithm of the triangles
constexpr double kRayMasked = 2;       // times as dear where all is masked
// Filtered ones: what every pixel pays, and each ray of all pixels, though penumbra alone has more than the first.
constexpr double kFilteredPerReceiver = 2.2e-4, kFilteredPerRay = 2.8e-6;
constexpr double kRayAdaptiveShare = 0.2;  // of the rays of every receiver: penumbra pays
// Rays a receiver until the mean error is .0016, and how they grow as it falls: of smooth surfaces, and of clutter.
constexpr double kRaysUntil = 52, kRaysUntilRate = 0.43, kClutteredRaysUntil = 500, kClutteredRaysUntilRate = 0.86;
// A map: its triangles, its texels, and a receiver that asks it.
constexpr double kMapPerTriangle = 2e-4, kMapPerTexel = 1e-6, kMapPerReceiver = 2.8e-5;
constexpr double kPyramidPerTexel = 1.5e-5;  // of a map's, for PCSS and SSSM
constexpr double kViewsInRooms = 5;
constexpr double kPcssPerTap = 5e-7;      // of the two squares of taps, with the skip
constexpr double kSssmPerTap = 2.4e-6;    // of the four rows of taps, of each cell
constexpr double kSsmPerTriangle = 8e-4;  // beside the map's, of finer texels
constexpr double kSsmPerPatch = 1.2e-5, kSsmPerReceiver = 3e-5;
// What GL draws, of the table's time, where a GPU draws it: not measured. Integrated ones fetch twenty texels a
// nanosecond, llvmpipe on two cores .6.
constexpr double kGpuShare = 1.0 / 30;
constexpr double kPdsmPerTexel = 1.2e-5, kPdsmPerReceiver = 1e-4;
constexpr int kMostSubLights = 4;  // that SSM chooses
constexpr int kMostSsmMap = 512;
// Mean errors: of rows of 32 samples, of stratified rays.
constexpr double kShaftErrorOfRow = 0.03;
constexpr int kMostRows = 64;
constexpr double kRayErrorOfRay = 0.2, kRayRate = 0.7;
constexpr double kFilteredErrorOfRay = 0.024, kFilteredRate = 0.45;
// Fitted to 200 scenes, lights and cameras at random (tests/accuracy/auto_gl_test), held against 200 others.
constexpr double kShaftErrorOfTold = 0.85, kFilteredErrorOfTold = 0.8;  // the first in shadow/shaft/shaft.cc too
// Where all is masked, leaves upon leaves, they are so many times as large.
constexpr double kClutteredRows = 2.2, kClutteredRays = 1.6;
constexpr double kClutteredRate = 0.25;  // and fall with the rows by so much less
// PDSM's: of its number of maps, and of texels, more for each so many triangles, which are finer than texels then; of
// leaves a thousandth of the pixels are off by half.
constexpr double kPdsmErrorOfMap = 0.1, kPdsmRate = 0.7;
constexpr double kPdsmErrorOfTexels = 0.002, kPdsmTriangles = 40'000, kClutteredPdsmError = 0.05;
// Those of maps fall with the sub-lights along an edge. Leaves are finer than texels, most of all where masks cut them.
constexpr double kSsmErrorOfMap = 0.026, kSsmRate = 1.2, kPcssError = 0.028, kSssmError = 0.015;
constexpr double kCluttered = 2, kMaskedMaps = 1.5;
// Of BLEND samples are coin tosses (scene/blend.h): mean |error| of one, sqrt(2 / pi) times the mean of sqrt(a (1 - a))
// over all a, pi / 8.
constexpr double kBlendNoise = 0.313;
// Wall time, of CPU time on as many threads as there are: drawing and encoding are partly on one.
constexpr double kWallPerCpu = 0.7;
constexpr double kEncodePerReceiver = 7e-5;

double RaysUntil(const MethodFacts& facts, double mean_error) {
  return std::pow(kRaysUntil * std::pow(0.0016 / mean_error, kRaysUntilRate), 1 - facts.clutter) *
         std::pow(kClutteredRaysUntil * std::pow(0.0016 / mean_error, kClutteredRaysUntilRate), facts.clutter);
}

double TriangleCount(const MethodFacts& facts) { return double(std::max<uint64_t>(facts.casting_triangles, 1)); }
double Squared(double x) { return x * x; }

// Milliseconds of one light: its data, and each receiver.
struct LightCost {
  double data = 0, per_receiver = 0;
};

double OnGl(const MethodFacts& facts, double ms) { return facts.has_gpu ? kGpuShare * ms : ms; }

LightCost MapsCost(const MethodFacts& facts, double views, double map_size) {
  const double maps = facts.has_side_windows ? kViewsInRooms * views : views;
  return {OnGl(facts, maps * (TriangleCount(facts) * kMapPerTriangle + Squared(map_size) * kMapPerTexel)),
          OnGl(facts, kFinishPerReceiver + maps * kMapPerReceiver)};
}

// The table, by method. RAY's hierarchy and SHAFT's shapes are the scene's, whatever the number of lights: PredictCost
// adds them.
struct CostOf {
  const MethodFacts& facts;

  LightCost operator()(const HardOptions& hard) const { return MapsCost(facts, 1, hard.map_size); }
  LightCost operator()(const MultiMapOptions& maps) const { return MapsCost(facts, maps.k, maps.map_size); }
  LightCost operator()(const RayOptions& ray) const {
    if (ray.is_filtered) {
      return {0, kFilteredPerReceiver + ray.rays * kFilteredPerRay * std::log2(TriangleCount(facts) + 2)};
    }
    const double rays = ray.max_error > 0 ? std::min(double(ray.rays), RaysUntil(facts, ray.max_error))
                        : ray.is_adaptive ? 16 + kRayAdaptiveShare * std::max(0, ray.rays - 16)
                                          : ray.rays;
    const double masks = 1 + (kRayMasked - 1) * facts.masked_share;
    return {0, rays * masks * kRayPerRay * std::log2(TriangleCount(facts) + 2)};
  }
  LightCost operator()(const PcssOptions& pcss) const {
    LightCost cost = MapsCost(facts, 1, pcss.map_size);
    cost.data += OnGl(facts, Squared(pcss.map_size) * kPyramidPerTexel);
    cost.per_receiver += OnGl(facts, kPcssPerTap * (Squared(pcss.blocker_taps) + Squared(pcss.filter_taps)));
    return cost;
  }
  LightCost operator()(const SssmOptions& sssm) const {
    const double cells = Squared(sssm.sub_lights);
    LightCost cost = MapsCost(facts, cells, sssm.map_size);
    cost.data += OnGl(facts, cells * Squared(sssm.map_size) * kPyramidPerTexel);
    cost.per_receiver += OnGl(facts, cells * kSssmPerTap * 2 * (sssm.blocker_taps + sssm.filter_taps));
    return cost;
  }
  LightCost operator()(const SsmOptions& ssm) const {
    const double q = ssm.sub_lights > 0 ? ssm.sub_lights : kMostSubLights;
    const double size = ssm.occluder_map_size > 0 ? ssm.occluder_map_size : kMostSsmMap;
    const double maps = q * q * ssm.passes;
    LightCost cost = MapsCost(facts, maps, size);
    cost.data += OnGl(facts, maps * TriangleCount(facts) * kSsmPerTriangle) + maps * Squared(size) * kSsmPerPatch;
    cost.per_receiver = OnGl(facts, kFinishPerReceiver + maps * kSsmPerReceiver);
    return cost;
  }
  LightCost operator()(const PdsmOptions& pdsm) const {
    LightCost cost = MapsCost(facts, pdsm.k, pdsm.map_size);
    cost.data += pdsm.k * Squared(pdsm.pdsm_size) * kPdsmPerTexel;
    cost.per_receiver = kFinishPerReceiver + kPdsmPerReceiver;
    return cost;
  }
  LightCost operator()(const ShaftOptions& shaft) const {
    const int rows = shaft.rows > 0 ? shaft.rows : ShaftRowsFor(facts, shaft.max_error);
    const double masks = kShaftMasked * facts.masked_share * (1 + kMaskedPerRow * (rows - 8));
    const double lists = kShaftPerPolygon * std::pow(TriangleCount(facts), kShaftGrowth) *
                         (1 + (kShaftCluttered - 1) * facts.clutter) * (1 + kShaftPerRow * (rows - 8) + masks);
    return {TriangleCount(facts) * (1 - facts.kept_share) * kShaftPerTriangle,
            kShaftPerReceiver + (shaft.is_sparse ? kShaftSparse : 1) * lists};
  }
};

// The box reaches from behind the light's plane to before it: beyond every slope of one map.
bool StandsBeside(const AreaLight& light, const Box3d& box) {
  Box3d in_light;
  const LightFrame frame = MakeLightFrame(light);
  for (int i = 0; i < 8; ++i) {
    in_light.Add(PointToLight(
        frame, {i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z}));
  }
  return in_light.min.z <= 0 && in_light.max.z > 0;
}

double Clutter(const MethodFacts& facts, double most) { return 1 + (most - 1) * facts.masked_share; }

double MapsClutter(const MethodFacts& facts) {
  return (1 + (kCluttered - 1) * facts.clutter) * Clutter(facts, kMaskedMaps);
}

double BlendNoise(const MethodFacts& facts, double samples) {
  return facts.blend_share * kBlendNoise / std::sqrt(samples);
}

}  // namespace

MethodFacts FactsForMethod(const FlatScene& scene, const Pose& pose, const RenderRequest& request, uint64_t receivers) {
  MethodFacts facts;
  uint64_t masked = 0, blend = 0, vertices = 0;
  std::vector<uint64_t> places(scene.meshes.size(), 0);  // without a mask
  for (const Instance& instance : pose.instances) {
    if (!instance.casts) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    facts.casting_triangles += mesh.TriangleCount();
    vertices += mesh.vertex_count;
    const MaskCoverage coverage = scene.CoverageOf(mesh);
    if (coverage == MaskCoverage::kFull) ++places[instance.mesh];
    if (coverage == MaskCoverage::kTested) {
      masked += mesh.TriangleCount();
      if (scene.materials[mesh.material].alpha_mode == AlphaMode::kBlend) blend += mesh.TriangleCount();
    }
    const Box3d box = WorldBox(scene, instance);
    facts.has_side_windows =
        facts.has_side_windows ||
        (!box.IsEmpty() && std::any_of(request.lights.begin(), request.lights.end(),
                                       [&](const AreaLight& light) { return StandsBeside(light, box); }));
  }
  uint64_t kept = 0;
  for (size_t i = 0; i < places.size(); ++i) {
    const uint64_t triangles = scene.meshes[i].TriangleCount();
    if (!IsWorthKeeping(triangles, places[i])) continue;
    kept += triangles * places[i];
    facts.kept_triangles += triangles;
  }
  if (facts.casting_triangles > 0) {
    facts.masked_share = double(masked) / double(facts.casting_triangles);
    facts.blend_share = double(blend) / double(facts.casting_triangles);
    facts.kept_share = double(kept) / double(facts.casting_triangles);
    // A closed surface has half as many vertices as triangles, a lone quad twice as many.
    const double apart = (double(vertices) / double(facts.casting_triangles) - 0.6) / (2 - 0.6);
    facts.clutter = std::max(facts.masked_share, std::clamp(apart, 0.0, 1.0));
  }
  facts.receivers = receivers;
  facts.lights = std::max<uint64_t>(request.lights.size(), 1);
  facts.frames = std::max<uint64_t>(request.expected_frames, 1);
  const auto asks = [&](OutputKind kind) {
    return std::find(request.outputs.begin(), request.outputs.end(), kind) != request.outputs.end();
  };
  facts.wants_penumbra_width = asks(OutputKind::kPenumbraWidth);
  facts.can_certify = asks(OutputKind::kFrame) || asks(OutputKind::kVisibility);
  facts.has_gpu = request.budget.machine.has_gpu;
  return facts;
}

PredictedCost PredictCost(const MethodFacts& facts, const MethodOptions& options) {
  const LightCost light = std::visit(CostOf{facts}, options);
  const auto lights = double(facts.lights);
  PredictedCost cost;
  cost.light_ms = lights * light.data;
  if (std::holds_alternative<RayOptions>(options)) cost.scene_ms = TriangleCount(facts) * kRayPerTriangle;
  if (std::holds_alternative<ShaftOptions>(options)) cost.scene_ms = double(facts.kept_triangles) * kShaftPerKept;
  cost.receiver_ms = kEach + double(facts.receivers) * (OnGl(facts, kPrimaryPerReceiver) + lights * light.per_receiver);
  return cost;
}

double PredictWallMs(const MethodFacts& facts, double cpu_ms, double slowness) {
  return slowness * (kWallPerCpu * cpu_ms + kEncodePerReceiver * double(facts.receivers));
}

double ShaftError(const MethodFacts& facts, int rows) {
  return kShaftErrorOfRow / rows * Clutter(facts, kClutteredRows) *
             std::pow(rows / 8.0, kClutteredRate * facts.masked_share) +
         BlendNoise(facts, 32.0 * rows);
}

int ShaftRowsFor(const MethodFacts& facts, double max_error) {
  int rows = 4;
  while (rows < kMostRows && ShaftError(facts, rows) > max_error) rows *= 2;
  return rows;
}

uint64_t ShaftPolygonsIn(const MethodFacts& facts, int rows, double ms) {
  const double beside =
      kEach + double(facts.receivers) * (OnGl(facts, kPrimaryPerReceiver) + double(facts.lights) * kShaftPerReceiver);
  return uint64_t(std::max(0.0, ms - beside) / (kShaftPerListed * (1 + kShaftPerRow * (rows - 8)))) + 1;
}

double RayError(const MethodFacts& facts, int rays) {
  return Clutter(facts, kClutteredRays) * kRayErrorOfRay * std::pow(rays, -kRayRate) + BlendNoise(facts, rays);
}

int RaysFor(const MethodFacts& facts, double max_error) {
  int rays = kFewestRays;
  while (rays < kMostRays && RayError(facts, rays) > max_error) rays *= 2;
  return rays;
}

double FilteredRayError(int rays) { return kFilteredErrorOfRay * std::pow(rays, -kFilteredRate); }

double ErrorOfTold(const MethodOptions& options) {
  if (std::holds_alternative<ShaftOptions>(options)) return kShaftErrorOfTold;
  const auto* ray = std::get_if<RayOptions>(&options);
  return ray != nullptr && ray->is_filtered ? kFilteredErrorOfTold : 1;
}

double PdsmError(const MethodFacts& facts, int k) {
  const double smooth = kPdsmErrorOfTexels * (1 + TriangleCount(facts) / kPdsmTriangles);
  return std::max(smooth, facts.clutter * kClutteredPdsmError) + kPdsmErrorOfMap * std::pow(k, -kPdsmRate);
}

double SsmError(const MethodFacts& facts, int sub_lights) {
  return kSsmErrorOfMap * MapsClutter(facts) * std::pow(sub_lights, -kSsmRate);
}

double PcssError(const MethodFacts& facts) { return kPcssError * MapsClutter(facts); }

double SssmError(const MethodFacts& facts) { return kSssmError * MapsClutter(facts); }

PredictedCost CertificateCost(const MethodFacts& facts, const CertifyOptions& certificate) {
  constexpr double kScattered = 4;          // rays to random pixels are no packets
  constexpr double kEachCertificate = 3.5;  // its pixels read, its interval drawn
  const double rays = 2.0 * certificate.pixels * certificate.rays;
  return {.scene_ms = TriangleCount(facts) * kRayPerTriangle,
          .receiver_ms = kEachCertificate + rays * kScattered * kRayPerRay * std::log2(TriangleCount(facts) + 2)};
}

}  // namespace halfshade
