// The bounded queue in front of the GL contexts. Thread-safe.
//
// Fair: principals (connections) take turns, and where the queue is full the newest job of the one who holds most of it
// makes room for one who holds less than an equal share. Of one principal's jobs those go together that find on a
// context what the job before them left there.
#pragma once

#include <absl/status/status.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "server/turns.h"

namespace halfshade {

class Renderer;
struct WorkerRenderer;

// A render that waits for a context. `run` is called once on a worker's thread, unless the job is withdrawn first.
struct RenderJob {
  uint64_t id = 0;
  std::string principal{};
  std::string affinity{};  // jobs of one affinity share scene and lights; "": shares nothing
  std::function<absl::Status(WorkerRenderer& worker)> run;  // what became of it on the worker
  // Called once in place of `run` where the job has to make room.
  std::function<void(const absl::Status&)> refuse = [](const absl::Status&) {};
  int overtaken = 0;  // the queue's own: by so many of its principal's
};

class RenderQueue {
 public:
  // At most `capacity` jobs wait; `workers` take them off.
  RenderQueue(size_t capacity, int workers);

  // RESOURCE_EXHAUSTED with push-back when the queue is full, or when the wait that it predicts from the renders so far
  // exceeds `time_left`; UNAVAILABLE once closed. On an error neither `run` nor `refuse` is ever called.
  absl::Status Push(RenderJob job, std::chrono::duration<double> time_left);

  // Takes a waiting job out. False if it runs already, or has run.
  bool Withdraw(uint64_t id);

  // The next job; waits for one. Nothing once the queue is closed and empty. Comes back with a job without `run` when
  // nothing waits but is_called() says that the worker has something else to do, asked again after every Call, and when
  // nothing came for so long. `affinity` is that of the job before.
  std::optional<RenderJob> Pop(
      const std::function<bool()>& is_called = [] { return false; },
      std::chrono::milliseconds idle = std::chrono::hours(24), const std::string& affinity = "");
  // Waits, for at most so long. False once the queue is closed.
  bool Pause(std::chrono::milliseconds time);
  // Lets every waiting worker ask is_called again.
  void Call();

  // How long a job took on its worker: what predicted waits are made of.
  void Report(std::chrono::duration<double> elapsed);

  // No more jobs come in; those that wait are still handed out.
  void Close();

  size_t waiting() const;

 private:
  std::chrono::duration<double> PredictedWait(const std::string& principal) const;  // under mutex_
  // Whoever has to make room for a job of `principal` in a full queue, or nobody; under mutex_.
  std::optional<RenderJob> MakeRoomFor(const std::string& principal);

  const size_t capacity_;
  const int workers_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Turns<RenderJob> jobs_;
  int running_ = 0;
  double mean_seconds_ = 0;  // exponential mean; 0 until the first render
  bool is_closed_ = false;
};

}  // namespace halfshade
