// Suites of one method each: its paper's figures, its forms, its rivals.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "client/bench/settings.h"
#include "client/bench/suites.h"

namespace halfshade::bench {

// As MakeSuite: "ssm", "sssm", "pdsm", "shaft", "auto".
absl::StatusOr<Suite> MakeSsmSuite(const std::vector<std::string>& methods);
absl::StatusOr<Suite> MakeSssmSuite(const std::vector<std::string>& methods, const std::string& scene_folder);
absl::StatusOr<Suite> MakePdsmSuite(const std::vector<std::string>& methods, const std::string& scene_folder);
absl::StatusOr<Suite> MakeShaftSuite(const std::vector<std::string>& methods, const std::string& scene_folder);
absl::StatusOr<Suite> MakeAutoSuite(const std::vector<std::string>& methods, const std::string& scene_folder);

// Table 6 of Buades et al. 2015: Gaussian weights, against lights that are weighed alike (Weighed).
std::vector<SettingText> GaussianSettings();

}  // namespace halfshade::bench
