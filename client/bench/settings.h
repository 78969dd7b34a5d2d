// Settings of methods out of words. Pure.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "client/bench/bench.h"

namespace halfshade::bench {

struct SettingText {
  const char* method;
  std::vector<std::string> options;  // "key=value"
  int filter_radius = 0;
};

// `methods`: those that the server has; others are left out, but for auto. INTERNAL for an option that a method lacks;
// "max_error" is the budget's.
absl::StatusOr<std::vector<Setting>> MakeSettings(const std::vector<SettingText>& texts,
                                                  const std::vector<std::string>& methods);

}  // namespace halfshade::bench
