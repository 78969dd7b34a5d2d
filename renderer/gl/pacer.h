// Bounds what is handed to GL at once: cancellation, deadlines and fairness act only between submissions.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <functional>

#include "renderer/gl/context.h"
#include "renderer/request.h"

namespace halfshade::gl {

class Pacer {
 public:
  // No submission may be predicted over this. A pass that would be is cut by its caller.
  static constexpr double kMaxSubmissionMs = 20;

  Pacer(const Context& context, StopCheck stop);
  // For tests: `finish` waits for the work handed out so far.
  Pacer(std::function<void()> finish, StopCheck stop) : finish_(std::move(finish)), stop_(std::move(stop)) {}

  // Before drawing what is predicted to take predicted_ms: finishes the work under way and asks the stop check if the
  // two together would pass the bound. The check's error comes back, and nothing more should be drawn.
  absl::Status Charge(double predicted_ms);
  // Finishes what is under way and asks the stop check.
  absl::Status Finish();

  uint64_t submissions() const { return submissions_; }
  double longest_predicted_ms() const { return longest_predicted_ms_; }

 private:
  std::function<void()> finish_;
  StopCheck stop_;
  double pending_ms_ = 0;
  double longest_predicted_ms_ = 0;
  uint64_t submissions_ = 0;
};

}  // namespace halfshade::gl
