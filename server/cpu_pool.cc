#include "server/cpu_pool.h"

namespace halfshade {

CpuPool::CpuPool(int threads) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Work(); });
}

CpuPool::~CpuPool() {
  {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void CpuPool::Run(std::function<void()> work, const std::string& principal) {
  {
    const std::lock_guard lock(mutex_);
    Queue& queue = queues_[principal];
    if (queue.empty()) turns_.push_back(principal);
    queue.push_back(std::move(work));
  }
  changed_.notify_one();
}

std::function<void()> CpuPool::TakeNext() {
  const std::string principal = std::move(turns_.front());
  turns_.pop_front();
  const auto found = queues_.find(principal);
  std::function<void()> work = std::move(found->second.front());
  found->second.pop_front();
  if (found->second.empty()) {
    queues_.erase(found);
  } else {
    turns_.push_back(principal);
  }
  return work;
}

void CpuPool::Work() {
  while (true) {
    std::function<void()> work;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return is_closed_ || !turns_.empty(); });
      if (turns_.empty()) return;
      work = TakeNext();
    }
    work();
  }
}

}  // namespace halfshade
