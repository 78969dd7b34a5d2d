// The GL workers of a server: one thread and one context each, fed by one queue.
#pragma once

#include <memory>
#include <vector>

#include "server/gl_worker.h"

namespace halfshade {

struct ServerOptions;

class GlWorkerPool {
 public:
  // Makes options.contexts workers, one after the other; the first error. `queue` outlives the pool and is closed
  // before it dies.
  absl::Status Start(const ServerOptions& options, RenderQueue* queue);

  const std::vector<std::unique_ptr<GlWorker>>& workers() const { return workers_; }

 private:
  std::vector<std::unique_ptr<GlWorker>> workers_;
};

}  // namespace halfshade
