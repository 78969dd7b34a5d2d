// The bounded queue in front of the GL contexts. Thread-safe.
#pragma once

#include <absl/status/status.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>

namespace halfshade {

class Renderer;
struct WorkerRenderer;

// A render that waits for a context. `run` is called once on a worker's thread, unless the job is withdrawn first.
struct RenderJob {
  uint64_t id = 0;
  std::function<void(WorkerRenderer& worker)> run;
};

class RenderQueue {
 public:
  // At most `capacity` jobs wait; `workers` take them off.
  RenderQueue(size_t capacity, int workers);

  // RESOURCE_EXHAUSTED with push-back when the queue is full, or when the wait that it predicts from the renders so far
  // exceeds `time_left`; UNAVAILABLE once closed. On an error `run` is never called.
  absl::Status Push(RenderJob job, std::chrono::duration<double> time_left);

  // Takes a waiting job out. False if it runs already, or has run.
  bool Withdraw(uint64_t id);

  // The next job; waits for one. Nothing once the queue is closed and empty. Comes back with a job without `run` when
  // nothing waits but is_called() says that the worker has something else to do; asked again after every Call.
  std::optional<RenderJob> Pop(const std::function<bool()>& is_called = [] { return false; });
  // Lets every waiting worker ask is_called again.
  void Call();

  // How long a job took on its worker: what predicted waits are made of.
  void Report(std::chrono::duration<double> elapsed);

  // No more jobs come in; those that wait are still handed out.
  void Close();

  size_t waiting() const;

 private:
  std::chrono::duration<double> PredictedWait() const;  // under mutex_

  const size_t capacity_;
  const int workers_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<RenderJob> jobs_;
  int running_ = 0;
  double mean_seconds_ = 0;  // exponential mean; 0 until the first render
  bool is_closed_ = false;
};

}  // namespace halfshade
