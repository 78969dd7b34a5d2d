// Threads for work that is neither gRPC's nor GL's: loading scenes, committing uploads, encoding images.
//
// Fair: each principal (a connection) has a queue of its own, and the queues take turns, so that one who asks for much
// delays another by the work that already runs and by one piece of its own, not by all of it.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace halfshade {

class CpuPool {
 public:
  explicit CpuPool(int threads);
  // Runs what is queued, then joins.
  ~CpuPool();
  // A principal's work starts in the order in which it came.
  void Run(std::function<void()> work, const std::string& principal = "");

 private:
  using Queue = std::deque<std::function<void()>>;

  void Work();
  std::function<void()> TakeNext();  // under mutex_; requires turns_

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Queue> queues_;  // of those who wait; none is empty
  std::deque<std::string> turns_;        // keys of queues_, the next one first
  bool is_closed_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace halfshade
