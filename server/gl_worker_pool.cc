#include "server/gl_worker_pool.h"

#include "renderer/status.h"
#include "server/options.h"

namespace halfshade {

absl::Status GlWorkerPool::Start(const ServerOptions& options, RenderQueue* queue) {
  const RendererFactory factory = options.renderer_factory
                                      ? options.renderer_factory
                                      : MakeGlRendererFactory(options.gl, options.limits.texture_pixels);
  for (int i = 0; i < options.contexts; ++i) {
    ASSIGN_OR_RETURN(auto worker, GlWorker::Start(factory, queue));
    workers_.push_back(std::move(worker));
  }
  return absl::OkStatus();
}

}  // namespace halfshade
