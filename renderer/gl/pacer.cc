#include "renderer/gl/pacer.h"

#include <glad/gl.h>

#include <algorithm>

#include "renderer/status.h"

namespace halfshade::gl {

Pacer::Pacer(const Context& context, StopCheck stop) : Pacer([&context] { context.gl().Finish(); }, std::move(stop)) {}

absl::Status Pacer::Charge(double predicted_ms) {
  if (pending_ms_ > 0 && pending_ms_ + predicted_ms > kMaxSubmissionMs) RETURN_IF_ERROR(Finish());
  pending_ms_ += predicted_ms;
  longest_predicted_ms_ = std::max(longest_predicted_ms_, pending_ms_);
  return absl::OkStatus();
}

absl::Status Pacer::Finish() {
  if (pending_ms_ > 0) {
    finish_();
    ++submissions_;
    pending_ms_ = 0;
  }
  return stop_();
}

}  // namespace halfshade::gl
