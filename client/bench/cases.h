// Scenes under lights for the bench: made by rule, or of view files; and curves of work that grows in steps.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

#include "client/bench/bench.h"
#include "client/bench/settings.h"

namespace halfshade::bench {

inline constexpr uint32_t kWidth = 640, kHeight = 360;  // unless told

struct MadeCase {
  const char* scene;
  double light_share = 0.2;
  uint32_t triangles = 0;
  uint32_t width = kWidth, height = kHeight;
  int lights = 1;
  bool receivers_alone = false;  // what casts has no shadow: errors and costs are those of the ground
  glm::dvec3 moved_m{0};         // what casts
};
Case MakeCase(const MadeCase& made);

// Against lights that are bright as a Gaussian, in settings of its own.
Case Weighed(Case bench_case, const std::vector<Setting>& settings);

// A view file's scene, camera and light. Its errors are those of the file.
absl::StatusOr<Case> CaseOfView(const std::string& view);
// Of `names` in scene_folder/views; none where there is no folder.
absl::StatusOr<std::vector<Case>> CasesOfViews(const std::string& scene_folder, const std::vector<std::string>& names);

// The same settings at every step.
CurvePlan MakeCurve(const std::string& work, const std::vector<std::pair<double, MadeCase>>& steps,
                    const std::vector<Setting>& settings);

// The same case in settings of another value of one option. `texts` without it; those are the curves' names.
absl::StatusOr<CurvePlan> MakeOptionCurve(const std::string& option, const std::vector<double>& values,
                                          const MadeCase& made, const std::vector<SettingText>& texts,
                                          const std::vector<std::string>& methods);

// Against triangles, light size, pixels and lights.
std::vector<CurvePlan> WorkCurves(const std::vector<Setting>& settings);

}  // namespace halfshade::bench
