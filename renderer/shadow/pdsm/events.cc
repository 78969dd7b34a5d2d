#include "renderer/shadow/pdsm/events.h"

#include <cmath>

namespace halfshade::pdsm {
namespace {

constexpr int kGuesses = 1024;  // steps are looked up from the depth in so many parts

}  // namespace

TexelSteps::TexelSteps(const Grid& grid, const SampleMap& map, const SamplePath& path)
    : grid_(grid), map_(map), path_(path), none_(int(path.steps.size())) {
  std::vector<uint16_t> guesses(kGuesses + 1);
  for (int i = 0; i <= kGuesses; ++i) guesses[i] = uint16_t(path.StepAt(float(i + 1) / kGuesses));
  steps_.resize(map.depths.size());
  for (size_t i = 0; i < steps_.size(); ++i) {
    const float depth = map.depths[i];
    int step = none_;
    if (depth > 0) {
      step = guesses[int(depth * kGuesses)];
      while (step + 1 < none_ && path.steps[step + 1].depth >= depth) ++step;
    }
    steps_[i] = uint16_t(step);
  }
  for (int q = 1; q < none_; ++q) {
    const glm::ivec2 move = path.steps[q].cell - path.steps[q - 1].cell;
    auto direction = std::find_if(directions_.begin(), directions_.end(),
                                  [&](const Direction& known) { return known.move == move; });
    if (direction == directions_.end()) {
      directions_.push_back({move, {}, {}});
      direction = directions_.end() - 1;
    }
    direction->steps.push_back(q);
  }
  for (Direction& direction : directions_) {
    direction.count_up_to.assign(size_t(none_) + 1, 0);
    for (const int q : direction.steps) direction.count_up_to[q] = 1;
    for (int q = 1; q <= none_; ++q) direction.count_up_to[q] += direction.count_up_to[q - 1];
  }
}

}  // namespace halfshade::pdsm
