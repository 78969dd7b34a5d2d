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
  double wall_ms = PredictWallMs(whole_facts, whole_ms, request.budget.machine.slowness);
  for (const Step& step : kSteps) {
    RenderRequest coarse = request;
    coarse.width = std::max(1, request.width / step.divisor);
    coarse.height = std::max(1, request.height / step.divisor);
    coarse.light_map_size = std::max(kLeastMapSize, request.light_map_size / step.divisor);
    coarse.samples = 1;
    coarse.certify.reset();
    coarse.budget = {.machine = request.budget.machine};
    coarse.is_auto = true;
    coarse.expected_frames = 0;  // each is drawn once
    const MethodFacts facts = FactsForMethod(scene, pose, coarse, ReceiverCount(coarse));
    // The first is to be there soon, whatever its data are good for later.
    const auto ms_of = [&](const MethodChoice& choice) {
      const bool has_data = !coarse_requests.empty() && (choice.options.index() == request.method.index() ||
                                                         choice.options.index() == coarse_requests[0].method.index());
      const PredictedCost cost = PredictCost(facts, choice.options);
      return has_data ? cost.receiver_ms : cost.TotalMs();
    };
    const double max_error = facts.wants_penumbra_width ? SssmError(facts) : step.max_error;
    std::vector<MethodChoice> candidates = MethodCandidates(facts, max_error);
    std::erase_if(candidates, [&](const MethodChoice& choice) { return choice.error > max_error; });
    const auto choice =
        std::min_element(candidates.begin(), candidates.end(),
                         [&](const MethodChoice& a, const MethodChoice& b) { return ms_of(a) < ms_of(b); });
    if (choice == candidates.end()) break;
    const double ms = ms_of(*choice);
    const double in_time_ms = wall_ms + PredictWallMs(facts, ms, request.budget.machine.slowness);
    if (ms > kMostShare * whole_ms) break;
    if (request.budget.max_latency_ms && in_time_ms > *request.budget.max_latency_ms) break;
    wall_ms = in_time_ms;
    coarse.method = choice->options;
    coarse.method_reason = "coarse, a " + std::string(step.divisor == 4 ? "quarter" : "half") +
                           " of the size asked for: " + choice->reason + ", which is the soonest there";
    coarse.predicted_error = choice->error;
    coarse.predicted_cpu_ms = ms;
    coarse_requests.push_back(std::move(coarse));
  }
  return coarse_requests;
}

}  // namespace halfshade
