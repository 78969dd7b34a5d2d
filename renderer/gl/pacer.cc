#include "renderer/gl/pacer.h"

#include <glad/gl.h>

#include <algorithm>

#include "renderer/gl/turn.h"
#include "renderer/status.h"

namespace halfshade::gl {
namespace {

constexpr double kTellingMs = 1;  // shorter submissions say more of calls than of drawing
constexpr double kMostSlowness = 8;
// Of llvmpipe each draw to another target is a scene of its own, in the first slot that is free, and what a slot's
// scene drew into and read stays in memory, deleted or not, until the slot is taken again. Many small draws at once
// (maps of few triangles) fill all 64 slots, of which it takes the first alone from then on: 63 scenes' textures stay
// for good.
constexpr int kMostSoftwareDraws = 8;

}  // namespace

Pacer::Pacer(const Context& context, StopCheck stop)
    : Pacer([&context] { context.gl().Finish(); }, std::move(stop),
            context.IsSoftware() ? kMostSoftwareDraws : std::numeric_limits<int>::max()) {}

absl::Status Pacer::Charge(double predicted_ms) {
  if (pending_ms_ > 0 && (pending_ms_ + predicted_ms > MostMs() || pending_draws_ >= most_draws_)) {
    RETURN_IF_ERROR(Finish());
  }
  if (pending_ms_ == 0) begin_ = std::chrono::steady_clock::now();
  pending_ms_ += predicted_ms;
  ++pending_draws_;
  longest_predicted_ms_ = std::max(longest_predicted_ms_, pending_ms_);
  return absl::OkStatus();
}

absl::Status Pacer::Finish() {
  if (pending_ms_ > 0) {
    finish_();
    ++submissions_;
    const double took_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_).count();
    if (pending_ms_ >= kTellingMs) slowness_ = std::clamp((slowness_ + took_ms / pending_ms_) / 2, 1.0, kMostSlowness);
    pending_ms_ = 0;
    pending_draws_ = 0;
  }
  PassTurn();
  return stop_();
}

}  // namespace halfshade::gl
