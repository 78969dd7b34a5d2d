#include "server/admission.h"

#include <algorithm>
#include <string>

#include "server/status.h"

namespace halfshade {
namespace {

// Weight of the newest render in the mean.
constexpr double kNewest = 0.2;
constexpr std::chrono::milliseconds kLeastPushback(50);

std::chrono::milliseconds Pushback(std::chrono::duration<double> wait) {
  return std::max(kLeastPushback, std::chrono::duration_cast<std::chrono::milliseconds>(wait));
}

}  // namespace

RenderQueue::RenderQueue(size_t capacity, int workers) : capacity_(capacity), workers_(workers) {}

std::chrono::duration<double> RenderQueue::PredictedWait() const {
  const double ahead = double(jobs_.size()) + running_ - workers_ + 1;
  return std::chrono::duration<double>(std::max(0.0, ahead) * mean_seconds_ / workers_);
}

absl::Status RenderQueue::Push(RenderJob job, std::chrono::duration<double> time_left) {
  const std::lock_guard lock(mutex_);
  if (is_closed_) return absl::UnavailableError("the server is draining");
  const auto wait = PredictedWait();
  if (jobs_.size() >= capacity_) {
    return ComeBackLater("the queue is full: " + std::to_string(capacity_) + " renders wait", Pushback(wait));
  }
  if (wait > time_left) {
    return ComeBackLater("the queue is too long for the deadline: a wait of " + std::to_string(wait.count()) +
                             " s is predicted, " + std::to_string(time_left.count()) + " s are left",
                         Pushback(wait - time_left));
  }
  jobs_.push_back(std::move(job));
  changed_.notify_one();
  return absl::OkStatus();
}

bool RenderQueue::Withdraw(uint64_t id) {
  RenderJob withdrawn;  // destroyed outside the lock
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(jobs_.begin(), jobs_.end(), [id](const RenderJob& job) { return job.id == id; });
  if (found == jobs_.end()) return false;
  withdrawn = std::move(*found);
  jobs_.erase(found);
  return true;
}

std::optional<RenderJob> RenderQueue::Pop(const std::function<bool()>& is_called) {
  std::unique_lock lock(mutex_);
  bool was_called = false;
  changed_.wait(lock, [&] { return is_closed_ || !jobs_.empty() || (was_called = is_called()); });
  if (jobs_.empty()) return was_called ? std::optional(RenderJob()) : std::nullopt;
  RenderJob job = std::move(jobs_.front());
  jobs_.pop_front();
  ++running_;
  return job;
}

void RenderQueue::Call() {
  const std::lock_guard lock(mutex_);
  changed_.notify_all();
}

void RenderQueue::Report(std::chrono::duration<double> elapsed) {
  const std::lock_guard lock(mutex_);
  --running_;
  mean_seconds_ = mean_seconds_ == 0 ? elapsed.count() : (1 - kNewest) * mean_seconds_ + kNewest * elapsed.count();
}

void RenderQueue::Close() {
  const std::lock_guard lock(mutex_);
  is_closed_ = true;
  changed_.notify_all();
}

size_t RenderQueue::waiting() const {
  const std::lock_guard lock(mutex_);
  return jobs_.size();
}

}  // namespace halfshade
