// AUTO: which method, with which options, for a request that names none. Pure; no GL.
//
// Decided by facts of scene and request and a table of costs and errors that belongs to the build (cost_model.h), never
// by clocks: the same request, the same choice. Where a latency is asked for, how slow this machine is counts too
// (Machine::slowness), and the choice may differ from one start of the server to the next.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/plan/cost_model.h"
#include "renderer/request.h"
#include "renderer/scene/flat_scene.h"
#include "renderer/scene/pose.h"

namespace halfshade {

struct MethodChoice {
  MethodOptions options;
  double error = 0;     // predicted: mean |error| of visibility over shadowed receivers
  double cpu_ms = 0;    // predicted: of all threads, primary visibility included, nothing cached
  double frame_ms = 0;  // PredictedCost::FrameMs: what is called cheap
  std::string reason;
};

// The methods that AUTO takes, each as it would be asked for `max_error`, from cheap to dear.
std::vector<MethodChoice> MethodCandidates(const MethodFacts& facts, double max_error);

// With max_error the cheapest that meets it; with max_latency_ms the most exact in time, of those that meet max_error
// where that is given too; with neither, as for an error of kDefaultMaxError. FAILED_PRECONDITION that begins with
// "budget" and names the best possible where nothing meets the budget.
absl::StatusOr<MethodChoice> ChooseMethod(const MethodFacts& facts, const Budget& budget);
inline constexpr double kDefaultMaxError = 0.002;

// Sets what ChooseMethod chooses where request->is_auto, the error that shaft chooses its rows for and that adaptive
// rays go on for where they are asked for by name with a max_error (the picture is checked against that:
// renderer/budget), and the certificate that a max_error comes with: always where the method does not tell its error.
// FAILED_PRECONDITION as ChooseMethod.
absl::Status SettleMethod(const FlatScene& scene, const Pose& pose, uint64_t receivers, RenderRequest* request);

// What to draw after a picture that broke max_error: shaft or adaptive rays once more at half of it, then rays
// everywhere, four times as many each time until there are no more (false). Shaft after maps. False where
// PENUMBRA_WIDTH is asked.
bool MakeMoreExact(const MethodFacts& facts, double max_error, MethodOptions* options);

// What AUTO draws where its method has no room for its light data, or where shaft's lists turn out to be longer than
// the other is dear: rays, which have none of either, the cheapest for max_error, or for shaft's own where the budget
// has none. False: it has no other. `request` is certified as SettleMethod does.
bool MakeSmaller(const MethodFacts& facts, double max_error, RenderRequest* request);

// What a certificate may cost of a request whose method is predicted to take cpu_ms: none, unless its rays and the
// hierarchy that they are traced in are a twentieth of that.
bool CertifiesByDefault(const MethodFacts& facts, double cpu_ms);
inline constexpr CertifyOptions kDefaultCertificate = {.pixels = 256, .rays = 64};

}  // namespace halfshade
