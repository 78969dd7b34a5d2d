#include "renderer/plan/coarse_request.h"

#include <algorithm>
#include <string>
#include <utility>

#include "renderer/plan/choose_method.h"
#include "renderer/plan/cost_model.h"

namespace halfshade {
namespace {

struct Step {
  int divisor;
  double max_error;
};
constexpr Step kSteps[] = {{4, 0.03}, {2, 0.01}};
constexpr double kMostShare = 0.5;
constexpr int kLeastMapSize = 16;

}  // namespace

std::vector<RenderRequest> PlanCoarseRequests(const FlatScene& scene, const Pose& pose, const RenderRequest& request) {
  std::vector<RenderRequest> coarse_requests;
  const double whole_ms = request.predicted_cpu_ms.value_or(0);
  const MethodFacts whole_facts = FactsForMethod(scene, pose, request, ReceiverCount(request));
  double wall_ms = PredictWallMs(whole_facts, whole_ms, request.budget.slowness);
  for (const Step& step : kSteps) {
    RenderRequest coarse = request;
    coarse.width = std::max(1, request.width / step.divisor);
    coarse.height = std::max(1, request.height / step.divisor);
    coarse.light_map_size = std::max(kLeastMapSize, request.light_map_size / step.divisor);
    coarse.samples = 1;
    coarse.certify.reset();
    coarse.budget = {};
    coarse.is_auto = true;
    coarse.expected_frames = 0;  // each is drawn once
    const MethodFacts facts = FactsForMethod(scene, pose, coarse, ReceiverCount(coarse));
    const double max_error = facts.wants_penumbra_width ? kSssmError : step.max_error;
    absl::StatusOr<MethodChoice> choice = ChooseMethod(facts, {.max_error = max_error});
    if (!choice.ok()) break;  // the whole says why
    const PredictedCost cost = PredictCost(facts, choice->options);
    const double ms = coarse_requests.empty() ? cost.TotalMs() : cost.receiver_ms;
    const double in_time_ms = wall_ms + PredictWallMs(facts, ms, request.budget.slowness);
    if (ms > kMostShare * whole_ms) break;
    if (request.budget.max_latency_ms && in_time_ms > *request.budget.max_latency_ms) break;
    wall_ms = in_time_ms;
    coarse.method = choice->options;
    coarse.method_reason = "coarse, a " + std::string(step.divisor == 4 ? "quarter" : "half") +
                           " of the size asked for: " + choice->reason;
    coarse.predicted_error = choice->error;
    coarse.predicted_cpu_ms = choice->cpu_ms;
    coarse_requests.push_back(std::move(coarse));
  }
  return coarse_requests;
}

}  // namespace halfshade
