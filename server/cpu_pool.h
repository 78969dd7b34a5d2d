// Threads for work that is neither gRPC's nor GL's: loading scenes, committing uploads, encoding images.
//
// Principals (connections) take turns.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/turns.h"

namespace halfshade {

class CpuPool {
 public:
  explicit CpuPool(int threads);
  // Runs what is queued, then joins.
  ~CpuPool();
  // A principal's work starts in the order in which it came.
  void Run(std::function<void()> work, const std::string& principal = "");

 private:
  void Work();

  std::mutex mutex_;
  std::condition_variable changed_;
  Turns<std::function<void()>> work_;
  bool is_closed_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace halfshade
