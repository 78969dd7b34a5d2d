// What a soak's samples of a resource say: does it grow?
#pragma once

#include <algorithm>
#include <vector>

namespace halfshade {

// A resource (MB, open files) over time.
struct SoakSample {
  double time_s = 0;
  double value = 0;
};

// Growth an hour after the warm-up, the first third: the median slope between samples of the first and of the last half
// of the rest, which single samples that stand out do not move (Theil and Sen). 0 of fewer than four samples.
inline double GrowthPerHour(const std::vector<SoakSample>& samples) {
  const size_t begin = samples.size() / 3, half = (samples.size() - begin) / 2;
  if (half < 2) return 0;
  std::vector<double> slopes;
  for (size_t i = begin; i + half < samples.size(); ++i) {
    const SoakSample &a = samples[i], &b = samples[i + half];
    slopes.push_back((b.value - a.value) / (b.time_s - a.time_s) * 3600);
  }
  const auto middle = slopes.begin() + long(slopes.size() / 2);
  std::nth_element(slopes.begin(), middle, slopes.end());
  return *middle;
}

}  // namespace halfshade
