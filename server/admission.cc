#include "server/admission.h"

#include <algorithm>
#include <string>

#include "server/status.h"

namespace halfshade {
namespace {

// Weight of the newest render in the mean.
constexpr double kNewest = 0.2;
constexpr std::chrono::milliseconds kLeastPushback(50);
// Then the first of its principal's jobs is next, whatever the context has.
constexpr int kMostOvertakings = 8;

std::chrono::milliseconds Pushback(std::chrono::duration<double> wait) {
  return std::max(kLeastPushback, std::chrono::duration_cast<std::chrono::milliseconds>(wait));
}

}  // namespace

RenderQueue::RenderQueue(size_t capacity, int workers) : capacity_(capacity), workers_(workers) {}

// Before a new job of the principal: of the others as many as it has itself, and its own.
std::chrono::duration<double> RenderQueue::PredictedWait(const std::string& principal) const {
  const size_t own = jobs_.CountOf(principal);
  double ahead = double(own) + running_ - workers_ + 1;
  for (const auto& [other, queue] : jobs_.queues()) {
    if (other != principal) ahead += double(std::min(queue.size(), own + 1));
  }
  return std::chrono::duration<double>(std::max(0.0, ahead) * mean_seconds_ / workers_);
}

std::optional<RenderJob> RenderQueue::MakeRoomFor(const std::string& principal) {
  const auto& queues = jobs_.queues();
  const auto greediest = std::max_element(
      queues.begin(), queues.end(), [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  const size_t own = jobs_.CountOf(principal);
  const size_t share = capacity_ / (queues.size() + (own == 0 ? 1 : 0));
  if (own >= share || greediest->second.size() <= share) return std::nullopt;
  return jobs_.RemoveNewest(greediest->first);
}

absl::Status RenderQueue::Push(RenderJob job, std::chrono::duration<double> time_left) {
  std::optional<RenderJob> displaced;
  absl::Status full;
  {
    const std::lock_guard lock(mutex_);
    if (is_closed_) return absl::UnavailableError("the server is draining");
    const auto wait = PredictedWait(job.principal);
    if (wait > time_left) {
      return ComeBackLater("the queue is too long for the deadline: a wait of " + std::to_string(wait.count()) +
                               " s is predicted, " + std::to_string(time_left.count()) + " s are left",
                           Pushback(wait - time_left));
    }
    if (jobs_.size() >= capacity_) {
      full = ComeBackLater("the queue is full: " + std::to_string(capacity_) + " renders wait", Pushback(wait));
      displaced = MakeRoomFor(job.principal);
      if (!displaced) return full;
    }
    const std::string principal = job.principal;
    jobs_.Push(principal, std::move(job));
    changed_.notify_one();
  }
  if (displaced) displaced->refuse(full);
  return absl::OkStatus();
}

bool RenderQueue::Withdraw(uint64_t id) {
  std::optional<RenderJob> withdrawn;  // destroyed outside the lock
  const std::lock_guard lock(mutex_);
  withdrawn = jobs_.Remove([id](const RenderJob& job) { return job.id == id; });
  return withdrawn.has_value();
}

std::optional<RenderJob> RenderQueue::Pop(const std::function<bool()>& is_called, std::chrono::milliseconds idle,
                                          const std::string& affinity) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, idle, [&] { return is_closed_ || !jobs_.empty() || is_called(); });
  if (jobs_.empty()) return is_closed_ ? std::nullopt : std::optional(RenderJob());
  RenderJob job = jobs_.Take([&](Turns<RenderJob>::Queue& queue) -> size_t {
    if (affinity.empty() || queue.front().overtaken >= kMostOvertakings) return 0;
    const auto found = std::find_if(queue.begin(), queue.end(),
                                    [&](const RenderJob& waiting) { return waiting.affinity == affinity; });
    if (found == queue.end()) return 0;
    if (found != queue.begin()) ++queue.front().overtaken;
    return size_t(found - queue.begin());
  });
  ++running_;
  return job;
}

bool RenderQueue::Pause(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, time, [&] { return is_closed_; });
  return !is_closed_;
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
