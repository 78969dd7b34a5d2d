#include "renderer/plan/choose_method.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "renderer/plan/cost_model.h"
#include "renderer/plan/frame_plan.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

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

MethodChoice MakeChoice(const MethodFacts& facts, const char* name, const MethodOptions& options, double error) {
  const PredictedCost cost = PredictCost(facts, options);
  return {options, error, cost.TotalMs(), cost.FrameMs(facts.frames), name};
}

// A sample of the picture's tiles says how many rows it wants, and rays tell their error as a mean: hence the margin.
double Wanted(double max_error) { return 0.8 * max_error; }

// As many where they disagree as this mean wants, few elsewhere. Of BLEND they are coin tosses, whose errors fall more
// slowly than rays tell.
RayOptions RaysUntil(const MethodFacts& facts, double mean_error) {
  if (facts.blend_share > 0) return {.rays = RaysFor(facts, mean_error)};
  constexpr double kClutter = 0.4;  // what they tell is so much too small of leaves
  return {.rays = kMostRays, .is_adaptive = true, .max_error = float(mean_error / (1 + kClutter * facts.clutter))};
}

MethodChoice Shaft(const MethodFacts& facts, double max_error) {
  const int rows = ShaftRowsFor(facts, max_error);
  MethodChoice choice = MakeChoice(facts, "shaft", ShaftOptions{.rows = rows}, ShaftError(facts, rows));
  choice.options = ShaftOptions{.rows = 0, .max_error = float(Wanted(max_error))};
  return choice;
}

MethodChoice Ray(const MethodFacts& facts, double max_error) {
  const RayOptions rays = RaysUntil(facts, Wanted(max_error));
  const double most = RayError(facts, rays.is_adaptive ? kFewestRays : rays.rays);
  return MakeChoice(facts, "ray", rays, std::max(std::min(max_error, most), RayError(facts, kMostRays)));
}

// Of methods that do not tell their error, or not surely.
MethodChoice Certified(const MethodFacts& facts, MethodChoice choice) {
  const PredictedCost certificate = CertificateCost(facts, kDefaultCertificate);
  choice.cpu_ms += certificate.TotalMs();
  choice.frame_ms += certificate.FrameMs(facts.frames);
  return choice;
}

// Neighbours' rays do for a pixel where surfaces and penumbrae are smooth. Where they are finer than four pixels, which
// no fact says, they are off by more than they tell.
std::optional<MethodChoice> FilteredRay(const MethodFacts& facts, double max_error) {
  constexpr double kMostClutter = 0.25;
  // Fewer are seen as steps; more are no cheaper than shaft.
  constexpr RayOptions kRays = {.rays = 4, .is_filtered = true};
  const double error = FilteredRayError(kRays.rays);
  if (facts.clutter > kMostClutter || error > Wanted(max_error)) return std::nullopt;
  return Certified(facts, MakeChoice(facts, "filtered ray", kRays, error));
}

// What its light data cost is paid back by many frames.
MethodChoice Pdsm(const MethodFacts& facts) {
  constexpr PdsmOptions kOptions = {.k = 256};  // fewer show their steps, however small their mean error
  return Certified(facts, MakeChoice(facts, "pdsm", kOptions, PdsmError(facts, kOptions.k)));
}

constexpr PcssOptions kPcss = {.blocker_taps = 11, .filter_taps = 21};
constexpr SsmOptions kSsm = {.occluder_map_size = 256, .sub_lights = 2};
constexpr SssmOptions kSssm = {.blocker_taps = 11, .filter_taps = 21, .weights = FilterWeights::kMean, .sub_lights = 2};

// It knows how wide penumbrae are.
MethodChoice PenumbraWidths(const MethodFacts& facts) { return MakeChoice(facts, "sssm", kSssm, SssmError(facts)); }

// A few maps and no rays, for coarse errors: nearly nothing where a GPU draws. In rooms, where a map is five, they are
// off by more than the table knows.
std::vector<MethodChoice> FewMaps(const MethodFacts& facts, double max_error) {
  std::vector<MethodChoice> choices;
  if (facts.has_side_windows) return choices;
  const auto add = [&](const char* name, const MethodOptions& options, double error) {
    if (error <= Wanted(max_error)) choices.push_back(Certified(facts, MakeChoice(facts, name, options, error)));
  };
  add("pcss", kPcss, PcssError(facts));
  add("ssm", kSsm, SsmError(facts, kSsm.sub_lights));
  add("sssm", kSssm, SssmError(facts));
  return choices;
}

// Its pictures come with their expected error (OcclusionSum::errors), which can be relied on.
bool TellsError(const MethodOptions& options) {
  if (const auto* ray = std::get_if<RayOptions>(&options)) return !ray->is_filtered;
  return std::holds_alternative<ShaftOptions>(options);
}

// Of those that meet the error; null if none do.
const MethodChoice* CheapestRays(const std::vector<MethodChoice>& candidates, double max_error) {
  const auto found = std::find_if(candidates.begin(), candidates.end(), [&](const MethodChoice& choice) {
    return std::holds_alternative<RayOptions>(choice.options) && choice.error <= max_error;
  });
  return found == candidates.end() ? nullptr : &*found;
}

// How long shaft's lists are depends on how a mesh is folded, which no fact says: from the tiles that choose its rows
// it knows, and leaves the picture to rays where those are cheaper. Masks' samples cost more than their polygons.
void BoundLists(const MethodFacts& facts, const MethodChoice* rays, MethodChoice* choice) {
  constexpr double kMostMasked = 0.1;
  constexpr double kWorthIt = 1.25;  // the tiles are lost, and neither cost is known well
  auto* shaft = std::get_if<ShaftOptions>(&choice->options);
  if (shaft == nullptr || rays == nullptr || facts.masked_share > kMostMasked) return;
  shaft->most_polygons = ShaftPolygonsIn(facts, ShaftRowsFor(facts, shaft->max_error), kWorthIt * rays->frame_ms);
}

// "shaft: predicted error 0.0019 in 190 CPU-ms"
std::string Describe(const MethodChoice& choice, uint64_t frames) {
  return choice.reason + ": predicted error " + Number(choice.error) + " in " + Milliseconds(choice.cpu_ms) +
         " CPU-ms, " + Milliseconds(choice.frame_ms) + " a frame of " +
         std::to_string(PredictedCost::FramesOfScene(frames));
}

void CertifyByDefault(const MethodFacts& facts, RenderRequest* request) {
  const bool shows_light = std::any_of(request->outputs.begin(), request->outputs.end(), [](OutputKind kind) {
    return kind == OutputKind::kFrame || kind == OutputKind::kVisibility;
  });
  if (!request->budget.max_error || request->certify || !shows_light) return;
  if (!TellsError(request->method)) {
    request->certify = kDefaultCertificate;
    request->method_reason += "; certified, since it does not tell its error";
  } else if (request->is_auto && CertifiesByDefault(facts, *request->predicted_cpu_ms)) {
    request->certify = kDefaultCertificate;
    request->method_reason += "; certified, for less than a twentieth of that";
  }
}

// Of a method that was asked for.
absl::Status CheckLatency(const MethodFacts& facts, double cpu_ms, const Budget& budget) {
  if (!budget.max_latency_ms) return absl::OkStatus();
  const double wall_ms = PredictWallMs(facts, cpu_ms, budget.machine.slowness);
  if (wall_ms <= *budget.max_latency_ms) return absl::OkStatus();
  return absl::FailedPreconditionError("budget.max_latency: " + Milliseconds(*budget.max_latency_ms) +
                                       " ms; the method with these options is predicted to take " +
                                       Milliseconds(wall_ms) + " ms");
}

}  // namespace

std::vector<MethodChoice> MethodCandidates(const MethodFacts& facts, double max_error) {
  std::vector<MethodChoice> candidates;
  if (facts.wants_penumbra_width) {
    candidates.push_back(PenumbraWidths(facts));
    return candidates;
  }
  candidates.push_back(Shaft(facts, max_error));
  candidates.push_back(Ray(facts, max_error));
  if (facts.can_certify) {
    if (const auto filtered = FilteredRay(facts, max_error)) candidates.push_back(*filtered);
    for (const MethodChoice& maps : FewMaps(facts, max_error)) candidates.push_back(maps);
    if (facts.frames > 1 && facts.masked_share == 0) candidates.push_back(Pdsm(facts));
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const MethodChoice& a, const MethodChoice& b) { return a.frame_ms < b.frame_ms; });
  return candidates;
}

absl::StatusOr<MethodChoice> ChooseMethod(const MethodFacts& facts, const Budget& budget) {
  // Errors to try, from what is asked for, or from the finest that a latency may leave time for.
  std::vector<double> errors;
  if (budget.max_latency_ms) {
    for (double error = RayError(facts, kMostRays); error < 0.2; error *= 2) {
      if (!budget.max_error || error < *budget.max_error) errors.push_back(error);
    }
    errors.push_back(budget.max_error.value_or(0.2));
  } else {
    // A method without another's exactness is the only one for what it alone knows.
    errors.push_back(budget.max_error.value_or(facts.wants_penumbra_width ? SssmError(facts) : kDefaultMaxError));
  }
  const auto wall_ms = [&](const MethodChoice& choice) {
    return PredictWallMs(facts, choice.cpu_ms, budget.machine.slowness);
  };
  // The best in error, and in time, of all that was looked at; and in error, of those that keep the budget.
  MethodChoice exact, quick, best;
  exact.error = quick.cpu_ms = best.error = std::numeric_limits<double>::infinity();
  const auto consider = [&](double error) {
    const std::vector<MethodChoice> candidates = MethodCandidates(facts, error);
    for (const MethodChoice& choice : candidates) {
      if (choice.error < exact.error) exact = choice;
      if (choice.cpu_ms < quick.cpu_ms) quick = choice;
      if (budget.max_error && choice.error > *budget.max_error) continue;
      if (budget.max_latency_ms && wall_ms(choice) > *budget.max_latency_ms) continue;
      if (choice.error >= best.error) continue;
      if (!budget.max_latency_ms && best.error < std::numeric_limits<double>::infinity()) continue;  // dearer
      best = choice;
      best.reason = "auto, " + Describe(choice, facts.frames);
      for (const MethodChoice& other : candidates) {
        if (&other != &choice) best.reason += "; " + Describe(other, facts.frames);
      }
      // What takes its place is for an error; a latency it might break.
      if (!budget.max_latency_ms) BoundLists(facts, CheapestRays(candidates, error), &best);
    }
  };
  for (const double error : errors) consider(error);
  // Rays take any error, so that the best in time is between two of those.
  for (double finer = best.error / 2; budget.max_latency_ms && finer > 0 && finer < 0.995 * best.error;) {
    const double error = std::sqrt(finer * best.error), before = best.error;
    consider(error);
    if (best.error == before) finer = error;
  }
  if (best.error < std::numeric_limits<double>::infinity()) {
    if (facts.wants_penumbra_width) best.reason += "; PENUMBRA_WIDTH is known to sssm and pcss";
    if (budget.max_latency_ms) {
      best.reason += "; the least error in " + Milliseconds(*budget.max_latency_ms) + " ms, of which it is to take " +
                     Milliseconds(wall_ms(best)) + ": this machine takes " + Number(budget.machine.slowness) +
                     " of the table's time";
    }
    return best;
  }
  if (budget.max_error && exact.error > *budget.max_error) {
    return absl::FailedPreconditionError("budget.max_error: " + Number(*budget.max_error) + "; the least possible is " +
                                         Number(exact.error) + ", by " + exact.reason);
  }
  return absl::FailedPreconditionError("budget.max_latency: " + Milliseconds(budget.max_latency_ms.value_or(0)) +
                                       " ms; the least possible is " + Milliseconds(wall_ms(quick)) +
                                       " ms at an error of " + Number(quick.error) + ", by " + quick.reason);
}

absl::Status SettleMethod(const FlatScene& scene, const Pose& pose, uint64_t receivers, RenderRequest* request) {
  const MethodFacts facts = FactsForMethod(scene, pose, *request, receivers);
  if (request->is_auto) {
    ASSIGN_OR_RETURN(MethodChoice choice, ChooseMethod(facts, request->budget));
    request->method = choice.options;
    request->method_reason = std::move(choice.reason);
    request->predicted_error = choice.error;
    request->predicted_cpu_ms = choice.cpu_ms;
  } else {
    if (auto* shaft = std::get_if<ShaftOptions>(&request->method); shaft != nullptr && request->budget.max_error) {
      shaft->max_error = float(Wanted(*request->budget.max_error));
    }
    if (auto* ray = std::get_if<RayOptions>(&request->method);
        ray != nullptr && ray->is_adaptive && request->budget.max_error) {
      ray->max_error = float(Wanted(*request->budget.max_error));
    }
    request->predicted_cpu_ms = PredictCost(facts, request->method).TotalMs();
    RETURN_IF_ERROR(CheckLatency(facts, *request->predicted_cpu_ms, request->budget));
  }
  if (auto* ssm = std::get_if<SsmOptions>(&request->method);
      ssm != nullptr && ssm->passes > 1 && IsOneFlatOccluder(scene, pose)) {
    ssm->passes = 1;
    request->method_reason += std::string(request->method_reason.empty() ? "" : "; ") +
                              "one flat surface casts: its second layer is its first";
  }
  CertifyByDefault(facts, request);
  return absl::OkStatus();
}

bool MakeSmaller(const MethodFacts& facts, double max_error, RenderRequest* request) {
  if (facts.wants_penumbra_width || std::holds_alternative<RayOptions>(request->method)) return false;
  if (const auto* shaft = std::get_if<ShaftOptions>(&request->method); shaft != nullptr && !request->budget.max_error) {
    max_error = shaft->max_error;
  }
  const std::vector<MethodChoice> candidates = MethodCandidates(facts, max_error);
  const MethodChoice* rays = CheapestRays(candidates, max_error);
  request->method = rays != nullptr ? rays->options : RaysUntil(facts, Wanted(max_error));
  request->predicted_cpu_ms = PredictCost(facts, request->method).TotalMs();
  CertifyByDefault(facts, request);
  return true;
}

bool MakeMoreExact(const MethodFacts& facts, double max_error, MethodOptions* options) {
  if (facts.wants_penumbra_width) return false;
  const float half = float(max_error / 2);
  if (auto* shaft = std::get_if<ShaftOptions>(options)) {
    if (shaft->max_error > half) {
      shaft->max_error = half;
    } else {
      *options = RayOptions{.rays = RaysFor(facts, half)};
    }
    return true;
  }
  auto* ray = std::get_if<RayOptions>(options);
  if (ray == nullptr) {
    *options = ShaftOptions{.rows = 0, .max_error = half};
  } else if (ray->is_filtered) {
    *options = RaysUntil(facts, half);
  } else if (ray->max_error > half) {
    ray->max_error = half;
  } else if (ray->max_error > 0) {
    *options = RayOptions{.rays = RaysFor(facts, half)};
  } else {
    if (ray->rays > kMostRays / 4) return false;
    ray->rays *= 4;
  }
  return true;
}

bool CertifiesByDefault(const MethodFacts& facts, double cpu_ms) {
  return CertificateCost(facts, kDefaultCertificate).TotalMs() <= 0.05 * cpu_ms;
}

}  // namespace halfshade
