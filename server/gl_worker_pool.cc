#include "server/gl_worker_pool.h"

#include <algorithm>

#include "renderer/status.h"
#include "server/options.h"

namespace halfshade {

absl::Status GlWorkerPool::Start(const ServerOptions& options, RenderQueue* queue, LightStore* light_store,
                                 const ImageDecoder& decoder, std::function<void(int lost)> on_health) {
  on_health_ = std::move(on_health);
  ContextWatch watch;
  watch.canary = std::chrono::milliseconds(options.canary_ms);
  watch.on_health = [this](bool is_well) {
    const std::lock_guard lock(mutex_);
    lost_ += is_well ? -1 : 1;
    if (!is_well) ++losses_;
    on_health_(lost_);
  };
  const uint64_t contexts = uint64_t(options.contexts);
  const ContextMemory memory = {.scene_bytes = (options.gl_scene_mb << 20) / contexts,
                                .light_data_bytes = (options.light_cache_mb << 20) / contexts,
                                .view_bytes = (options.view_cache_mb << 20) / contexts,
                                .ray_scene_bytes = (options.ray_scene_mb << 20) / contexts * 2 / 3,
                                .scene_data_bytes = (options.ray_scene_mb << 20) / contexts / 3,
                                .light_store = light_store};
  const RendererFactory factory =
      options.renderer_factory ? options.renderer_factory : MakeGlRendererFactory(options.gl, decoder, memory);
  for (int i = 0; i < options.contexts; ++i) {
    ASSIGN_OR_RETURN(auto worker, GlWorker::Start(factory, queue, watch));
    workers_.push_back(std::move(worker));
  }
  return absl::OkStatus();
}

void GlWorkerPool::Join() {
  for (const auto& worker : workers_) worker->Join();
}

void GlWorkerPool::ForgetScene(const std::string& name) {
  for (const auto& worker : workers_) worker->ForgetScene(name);
}

std::vector<CacheReport> GlWorkerPool::Caches() const {
  std::vector<CacheReport> sums;
  for (const auto& worker : workers_) {
    for (const CacheReport& cache : worker->Caches()) {
      const auto is_same = [&](const CacheReport& sum) { return sum.name == cache.name; };
      auto sum = std::find_if(sums.begin(), sums.end(), is_same);
      if (sum == sums.end()) sum = sums.insert(sums.end(), {.name = cache.name});
      sum->hits += cache.hits;
      sum->misses += cache.misses;
      sum->bytes += cache.bytes;
    }
  }
  return sums;
}

Machine GlWorkerPool::machine() const {
  Machine all = {.slowness = 0, .has_gpu = true};
  for (const auto& worker : workers_) {
    all.slowness = std::max(all.slowness, worker->machine().slowness);
    all.has_gpu = all.has_gpu && worker->machine().has_gpu;
  }
  return all;
}

}  // namespace halfshade
