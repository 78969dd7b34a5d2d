// The GL workers of a server: one thread and one context each, fed by one queue.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/gl_worker.h"

namespace halfshade {

struct ServerOptions;

class GlWorkerPool {
 public:
  // Makes options.contexts workers, one after the other; the first error. `queue` outlives the pool and is closed
  // before it dies; `light_store`, which may be null, outlives it too. `on_health` is called with the number of
  // contexts that do not draw whenever it changes, from the workers' threads, one call at a time.
  absl::Status Start(const ServerOptions& options, RenderQueue* queue, LightStore* light_store,
                     const ImageDecoder& decoder, std::function<void(int lost)> on_health);

  // Waits for the end of all threads; the queue is closed before. Everything below may still be called.
  void Join();

  // Of every context. Thread-safe once started.
  void ForgetScene(const std::string& name);
  // Summed over the contexts. Thread-safe once started.
  std::vector<CacheReport> Caches() const;

  // Contexts that do not draw now, and how often one stopped since the start. Thread-safe.
  int lost() const { return lost_; }
  uint64_t losses() const { return losses_; }
  // What any context can be relied on for: the slowest's slowness, a GPU where all have one.
  Machine machine() const;

  const std::vector<std::unique_ptr<GlWorker>>& workers() const { return workers_; }

 private:
  std::mutex mutex_;  // over calls of on_health_
  std::atomic<int> lost_{0};
  std::atomic<uint64_t> losses_{0};
  std::function<void(int lost)> on_health_;
  std::vector<std::unique_ptr<GlWorker>> workers_;
};

}  // namespace halfshade
