// Bounds what is handed to GL at once: cancellation, deadlines and fairness act only between submissions.
#pragma once

#include <absl/status/status.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>

#include "renderer/gl/context.h"
#include "renderer/request.h"

namespace halfshade::gl {

class Pacer {
 public:
  // No submission may be predicted over this.
  static constexpr double kMaxSubmissionMs = 20;
  // The longest that a pass should predict for one draw: it cuts itself into such. Less than the bound where what was
  // drawn so far took longer than was predicted.
  double MostMs() const { return kMaxSubmissionMs / slowness_; }

  Pacer(const Context& context, StopCheck stop);
  // For tests: `finish` waits for the work handed out so far, which is of `most_draws` at most.
  Pacer(std::function<void()> finish, StopCheck stop, int most_draws = std::numeric_limits<int>::max())
      : finish_(std::move(finish)), stop_(std::move(stop)), most_draws_(most_draws) {}

  // Before drawing what is predicted to take predicted_ms: finishes the work under way and asks the stop check if the
  // two together would pass MostMs, or the draws that this context may have under way. The check's error comes back,
  // and nothing more should be drawn.
  absl::Status Charge(double predicted_ms);
  // Finishes what is under way and asks the stop check.
  absl::Status Finish();
  // Asks the stop check alone: from any thread.
  absl::Status Ask() const { return stop_(); }

  uint64_t submissions() const { return submissions_; }
  double longest_predicted_ms() const { return longest_predicted_ms_; }

 private:
  std::function<void()> finish_;
  StopCheck stop_;
  int most_draws_;
  int pending_draws_ = 0;
  double pending_ms_ = 0;
  std::chrono::steady_clock::time_point begin_;  // of what is pending
  double slowness_ = 1;                          // what submissions took, over what was predicted
  double longest_predicted_ms_ = 0;
  uint64_t submissions_ = 0;
};

}  // namespace halfshade::gl
