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
    work_.Push(principal, std::move(work));
  }
  changed_.notify_one();
}

void CpuPool::Work() {
  while (true) {
    std::function<void()> work;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return is_closed_ || !work_.empty(); });
      if (work_.empty()) return;
      work = work_.Take();
    }
    work();
  }
}

}  // namespace halfshade
