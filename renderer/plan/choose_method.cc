#include "renderer/plan/choose_method.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "renderer/status.h"

namespace halfshade {
namespace {

// CPU-ms; llvmpipe and Embree on two cores (README.md: the commands that print what they were fitted to).
constexpr double kPrimaryPerReceiver = 4e-5;
constexpr double kShaftPerTriangle = 8e-4;
constexpr double kShaftPerReceiver = 2e-5;
constexpr double kShaftPerPolygon = 2.4e-6;  // times the square root of the triangles: what a tile's list grows like
constexpr double kShaftPerRow = 1.0 / 40;    // of that, for each row beyond 8
constexpr double kShaftMasked = 15;          // times as dear where all is masked
constexpr double kRayPerTriangle = 1e-3;
constexpr double kRayPerRay = 1.6e-6;      // times the logarithm of the triangles
constexpr double kPcssPerReceiver = 6e-4;  // sssm, 2 x 2 cells, 11 and 21 taps a side
// Mean errors: of rows of 32 samples, of stratified rays.
constexpr double kShaftErrorOfRow = 0.03;
constexpr double kRayError = 0.2, kRayRate = 0.7;
constexpr double kSssmError = 0.03;
// Where all is masked, leaves upon leaves, they are so many times as large.
constexpr double kClutteredRows = 2.2, kClutteredRays = 1.6;
constexpr int kMostMaskedRows = 16;  // shaft chooses no more where there is a mask
constexpr int kMostRays = 65536;
// Wall time, of CPU time on as many threads as there are: drawing and encoding are partly on one.
constexpr double kWallPerCpu = 0.7;
constexpr double kEncodePerReceiver = 7e-5;

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2g", value);
  return text;
}

std::string Milliseconds(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), value < 10 ? "%.1f" : "%.0f", value);
  return text;
}

double TriangleCount(const MethodFacts& facts) { return double(std::max<uint64_t>(facts.casting_triangles, 1)); }

double ShaftError(const MethodFacts& facts, int rows) {
  return kShaftErrorOfRow / rows * (1 + (kClutteredRows - 1) * facts.masked_share);
}

MethodChoice Shaft(const MethodFacts& facts, int rows, double max_error) {
  MethodChoice choice;
  // Left open, so that the picture itself says how many rows it wants; a sample of its tiles does, hence the margin.
  choice.options = ShaftOptions{.rows = 0, .max_error = float(0.8 * max_error)};
  choice.error = ShaftError(facts, rows);
  const double lists = double(facts.receivers) * kShaftPerPolygon * std::sqrt(TriangleCount(facts)) *
                       (1 + kShaftPerRow * (rows - 8)) * (1 + kShaftMasked * facts.masked_share);
  choice.cpu_ms = double(facts.receivers) * kPrimaryPerReceiver +
                  double(facts.lights) *
                      (TriangleCount(facts) * kShaftPerTriangle + double(facts.receivers) * kShaftPerReceiver + lists);
  choice.reason = "shaft";
  return choice;
}

// `clutter`: kClutteredRays as far as the scene is.
int RaysFor(double max_error, double clutter) {
  const double wanted = std::pow(clutter * kRayError / max_error, 1 / kRayRate);
  int rays = 16;
  while (rays < kMostRays && rays < wanted) rays *= 2;
  return rays;
}

MethodChoice Ray(const MethodFacts& facts, double max_error) {
  const double clutter = 1 + (kClutteredRays - 1) * facts.masked_share;
  const int rays = RaysFor(max_error, clutter);
  MethodChoice choice;
  choice.options = RayOptions{.rays = rays};
  choice.error = clutter * kRayError * std::pow(rays, -kRayRate);
  choice.cpu_ms =
      double(facts.receivers) * kPrimaryPerReceiver + TriangleCount(facts) * kRayPerTriangle +
      double(facts.lights) * double(facts.receivers) * rays * kRayPerRay * std::log2(TriangleCount(facts) + 2);
  choice.reason = "ray";
  return choice;
}

// The methods that know how wide penumbrae are.
MethodChoice PenumbraWidths(const MethodFacts& facts) {
  SssmOptions options;
  options.blocker_taps = 11;
  options.filter_taps = 21;
  options.weights = FilterWeights::kMean;
  options.sub_lights = 2;
  MethodChoice choice;
  choice.options = options;
  choice.error = kSssmError;
  choice.cpu_ms = double(facts.receivers) * (kPrimaryPerReceiver + double(facts.lights) * kPcssPerReceiver);
  choice.reason = "sssm";
  return choice;
}

// Its pictures come with their expected error (OcclusionSum::errors).
bool TellsError(const MethodOptions& options) {
  return std::holds_alternative<ShaftOptions>(options) || std::holds_alternative<RayOptions>(options);
}

double WallMs(const MethodFacts& facts, const MethodChoice& choice) {
  return kWallPerCpu * choice.cpu_ms + kEncodePerReceiver * double(facts.receivers);
}

// "shaft: predicted error 0.0019 in 190 CPU-ms"
std::string Describe(const MethodChoice& choice) {
  return choice.reason + ": predicted error " + Number(choice.error) + " in " + Milliseconds(choice.cpu_ms) + " CPU-ms";
}

}  // namespace

MethodFacts FactsForMethod(const FlatScene& scene, const Pose& pose, const RenderRequest& request, uint64_t receivers) {
  MethodFacts facts;
  uint64_t masked = 0;
  for (const Instance& instance : pose.instances) {
    if (!instance.casts) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    facts.casting_triangles += mesh.TriangleCount();
    if (scene.CoverageOf(mesh) == MaskCoverage::kTested) masked += mesh.TriangleCount();
  }
  if (facts.casting_triangles > 0) facts.masked_share = double(masked) / double(facts.casting_triangles);
  facts.receivers = receivers;
  facts.lights = std::max<uint64_t>(request.lights.size(), 1);
  facts.wants_penumbra_width =
      std::find(request.outputs.begin(), request.outputs.end(), OutputKind::kPenumbraWidth) != request.outputs.end();
  return facts;
}

std::vector<MethodChoice> MethodCandidates(const MethodFacts& facts, double max_error) {
  std::vector<MethodChoice> candidates;
  if (facts.wants_penumbra_width) {
    candidates.push_back(PenumbraWidths(facts));
    return candidates;
  }
  const int most_rows = facts.masked_share > 0 ? kMostMaskedRows : 64;
  int rows = 8;
  while (rows < most_rows && ShaftError(facts, rows) > max_error) rows *= 2;
  candidates.push_back(Shaft(facts, rows, max_error));
  candidates.push_back(Ray(facts, max_error));
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const MethodChoice& a, const MethodChoice& b) { return a.cpu_ms < b.cpu_ms; });
  return candidates;
}

absl::StatusOr<MethodChoice> ChooseMethod(const MethodFacts& facts, const Budget& budget) {
  // Errors to try, from what is asked for, or from the finest that a latency may leave time for.
  std::vector<double> errors;
  if (budget.max_latency_ms) {
    for (double error = 1e-4; error < 0.2; error *= 2) {
      if (!budget.max_error || error < *budget.max_error) errors.push_back(error);
    }
    errors.push_back(budget.max_error.value_or(0.2));
  } else {
    // A method without another's exactness is the only one for what it alone knows.
    errors.push_back(budget.max_error.value_or(facts.wants_penumbra_width ? kSssmError : kDefaultMaxError));
  }
  MethodChoice exact, quick;  // the best in error, and in time, of all that was looked at
  exact.error = quick.cpu_ms = std::numeric_limits<double>::infinity();
  for (const double error : errors) {
    const std::vector<MethodChoice> candidates = MethodCandidates(facts, error);
    for (size_t i = 0; i < candidates.size(); ++i) {
      MethodChoice choice = candidates[i];
      if (choice.error < exact.error) exact = choice;
      if (choice.cpu_ms < quick.cpu_ms) quick = choice;
      if (budget.max_error && choice.error > *budget.max_error) continue;
      if (budget.max_latency_ms && WallMs(facts, choice) > *budget.max_latency_ms) continue;
      choice.reason = "auto, " + Describe(choice);
      for (size_t other = 0; other < candidates.size(); ++other) {
        if (other != i) choice.reason += "; " + Describe(candidates[other]);
      }
      if (facts.wants_penumbra_width) choice.reason += "; PENUMBRA_WIDTH is known to sssm and pcss";
      return choice;
    }
  }
  if (budget.max_error && exact.error > *budget.max_error) {
    return absl::FailedPreconditionError("budget.max_error: " + Number(*budget.max_error) + "; the least possible is " +
                                         Number(exact.error) + ", by " + exact.reason);
  }
  return absl::FailedPreconditionError("budget.max_latency: " + Milliseconds(budget.max_latency_ms.value_or(0)) +
                                       " ms; the least possible is " + Milliseconds(WallMs(facts, quick)) +
                                       " ms at an error of " + Number(quick.error) + ", by " + quick.reason);
}

absl::Status SettleMethod(const FlatScene& scene, const Pose& pose, uint64_t receivers, RenderRequest* request) {
  const bool shows_light = std::any_of(request->outputs.begin(), request->outputs.end(), [](OutputKind kind) {
    return kind == OutputKind::kFrame || kind == OutputKind::kVisibility;
  });
  const bool may_certify = request->budget.max_error && !request->certify && shows_light;
  const MethodFacts facts = FactsForMethod(scene, pose, *request, receivers);
  if (request->is_auto) {
    ASSIGN_OR_RETURN(MethodChoice choice, ChooseMethod(facts, request->budget));
    request->method = choice.options;
    request->method_reason = std::move(choice.reason);
    request->predicted_error = choice.error;
    request->predicted_cpu_ms = choice.cpu_ms;
  }
  if (!may_certify) return absl::OkStatus();
  if (!TellsError(request->method)) {
    request->certify = kDefaultCertificate;
    request->method_reason += "; certified, since it does not tell its error";
  } else if (request->is_auto && CertifiesByDefault(facts, *request->predicted_cpu_ms)) {
    request->certify = kDefaultCertificate;
    request->method_reason += "; certified, for less than a twentieth of that";
  }
  return absl::OkStatus();
}

bool MakeMoreExact(double max_error, MethodOptions* options) {
  if (auto* shaft = std::get_if<ShaftOptions>(options)) {
    const float half = float(max_error / 2);
    if (shaft->max_error > half) {
      shaft->max_error = half;
    } else {
      *options = RayOptions{.rays = RaysFor(half, 1)};
    }
    return true;
  }
  if (auto* ray = std::get_if<RayOptions>(options)) {
    if (ray->rays > kMostRays / 4) return false;
    ray->rays *= 4;
    return true;
  }
  return false;
}

bool CertifiesByDefault(const MethodFacts& facts, double cpu_ms) {
  constexpr double kScattered = 4;  // rays to random pixels are no packets
  const double rays = 2.0 * kDefaultCertificate.pixels * kDefaultCertificate.rays;
  const double cost =
      TriangleCount(facts) * kRayPerTriangle + rays * kScattered * kRayPerRay * std::log2(TriangleCount(facts) + 2);
  return cost <= 0.05 * cpu_ms;
}

}  // namespace halfshade
