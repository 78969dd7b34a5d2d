// Threads for work that is neither gRPC's nor GL's: loading scenes, encoding images, committing uploads.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace halfshade {

class CpuPool {
 public:
  explicit CpuPool(int threads);
  // Runs what is queued, then joins.
  ~CpuPool();
  void Run(std::function<void()> work);

 private:
  void Work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> queue_;
  bool is_closed_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace halfshade
