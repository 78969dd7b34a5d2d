// The GL workers of a server: one thread and one context each, fed by one queue.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "server/gl_worker.h"

namespace halfshade {

struct ServerOptions;

class GlWorkerPool {
 public:
  // Makes options.contexts workers, one after the other; the first error. `queue` outlives the pool and is closed
  // before it dies; `light_store`, which may be null, outlives it too.
  absl::Status Start(const ServerOptions& options, RenderQueue* queue, LightStore* light_store);

  // Waits for the end of all threads; the queue is closed before. Everything below may still be called.
  void Join();

  // Of every context. Thread-safe once started.
  void ForgetScene(const std::string& name);
  // Summed over the contexts. Thread-safe once started.
  std::vector<CacheReport> Caches() const;

  // Of the slowest context.
  double Slowness() const;

  const std::vector<std::unique_ptr<GlWorker>>& workers() const { return workers_; }

 private:
  std::vector<std::unique_ptr<GlWorker>> workers_;
};

}  // namespace halfshade
