// What the bench measures: which scenes, lights, methods and settings.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "client/bench/bench.h"
#include "client/bench/sequences.h"

namespace halfshade::bench {

struct Suite {
  std::vector<Case> cases;
  std::vector<Setting> settings;
  std::vector<CurvePlan> curves;
  std::vector<SequencePlan> sequences;
  std::vector<Case> replies;  // of which ReplyTimes are measured
  Effort effort;
  std::string judged;  // Results::judged
};

// "quick": four classes under one light, two minutes on two cores. "full": all classes under lights of .05, .2 and .5
// of the occluders' extent, the views of `scene_folder` (a folder with scenes/ and views/; "" for none), and curves of
// cost. "sssm": the tables of Buades et al. 2015, two lights on leaves, and trees. "ssm": errors on receivers alone,
// and the trends of Atty et al. 2006 as curves. "pdsm": the forms of attenuation functions, and curves in k and both
// sizes. "shaft": its cost beside the cheapest rival's at equal error, on all classes and six views, and what it grows
// with. "auto": the same of AUTO at its budgets, and frames in a row as users ask for them. `methods`: those that the
// server has; others are left out.
absl::StatusOr<Suite> MakeSuite(const std::string& name, const std::vector<std::string>& methods,
                                const std::string& scene_folder);

// One repetition at a small size: that nothing is broken, not how fast it is.
absl::StatusOr<Suite> MakeSmokeSuite(const std::vector<std::string>& methods);

// A user's own scenes, as the renderer frames them, in the settings of "full".
absl::StatusOr<Suite> MakeSceneSuite(const std::vector<std::string>& paths, const std::vector<std::string>& methods);

}  // namespace halfshade::bench
