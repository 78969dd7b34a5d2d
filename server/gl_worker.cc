#include "server/gl_worker.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <future>

#include "renderer/calibrate.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLongestPause(2000);  // between attempts to get a context

}  // namespace

RendererFactory MakeGlRendererFactory(const gl::ContextOptions& options, const ImageDecoder& decoder,
                                      const ContextMemory& memory) {
  return [options, decoder, memory]() -> absl::StatusOr<WorkerRenderer> {
    WorkerRenderer worker;
    ASSIGN_OR_RETURN(worker.context, gl::Context::Create(options));
    ASSIGN_OR_RETURN(worker.renderer, Renderer::Create(worker.context.get(), decoder, memory));
    worker.gl_renderer = worker.context->renderer();
    worker.gl_version = worker.context->version();
    worker.description = worker.context->description();
    worker.machine.has_gpu = !worker.context->IsSoftware();
    ASSIGN_OR_RETURN(worker.machine.slowness, MeasureSlowness(*worker.renderer));
    return worker;
  };
}

absl::StatusOr<std::unique_ptr<GlWorker>> GlWorker::Start(const RendererFactory& factory, RenderQueue* queue,
                                                          const ContextWatch& watch) {
  std::promise<absl::StatusOr<WorkerRenderer>> started;
  auto worker = std::unique_ptr<GlWorker>(new GlWorker(factory, queue, watch));
  worker->thread_ = std::thread([&started, self = worker.get()] {
    absl::StatusOr<WorkerRenderer> made = self->factory_();
    if (!made.ok()) {
      started.set_value(made.status());
      return;
    }
    WorkerRenderer own = *std::move(made);
    WorkerRenderer words;
    words.gl_renderer = own.gl_renderer;
    words.gl_version = own.gl_version;
    words.description = own.description;
    words.machine = own.machine;
    started.set_value(std::move(words));  // the reference is gone from here on
    self->Work(std::move(own));
  });
  ASSIGN_OR_RETURN(worker->info_, started.get_future().get());
  return worker;
}

void GlWorker::Work(WorkerRenderer own) {
  const auto is_called = [this] {
    const std::lock_guard lock(mutex_);
    return !forgotten_.empty();
  };
  auto checked_at = SteadyClock::now();
  std::string affinity;
  while (std::optional<RenderJob> job = queue_->Pop(is_called, watch_.canary, affinity)) {
    bool is_suspect = false;
    if (job->run) {
      affinity = job->affinity;
      const auto begin = SteadyClock::now();
      const absl::Status status = job->run(own);
      queue_->Report(SteadyClock::now() - begin);
      is_suspect = absl::IsInternal(status) || absl::IsUnavailable(status);
    }
    if (own.renderer == nullptr) continue;
    if (is_suspect || (!job->run && SteadyClock::now() - checked_at >= watch_.canary)) {
      checked_at = SteadyClock::now();
      if (const absl::Status status = own.renderer->CheckCanary(); !status.ok()) {
        spdlog::error("{} draws no more: {}", own.description, status.ToString());
        if (!Rebuild(&own)) return;
        spdlog::info("{} draws again", own.description);
      }
    }
    Tidy(*own.renderer);
  }
}

bool GlWorker::Rebuild(WorkerRenderer* own) {
  watch_.on_health(false);
  for (std::chrono::milliseconds pause(50);; pause = std::min(2 * pause, kLongestPause)) {
    own->renderer.reset();
    own->context.reset();
    absl::StatusOr<WorkerRenderer> made = factory_();
    if (made.ok()) {
      *own = *std::move(made);
      watch_.on_health(true);
      return true;
    }
    spdlog::error("no context: {}", made.status().ToString());
    if (!queue_->Pause(pause)) return false;
  }
}

void GlWorker::Tidy(Renderer& renderer) {
  std::vector<std::string> forgotten;
  {
    const std::lock_guard lock(mutex_);
    forgotten.swap(forgotten_);
  }
  for (const std::string& name : forgotten) renderer.ForgetScene(name);
  const std::vector<CacheReport> caches = renderer.Caches();
  const std::lock_guard lock(mutex_);
  caches_ = caches;
}

void GlWorker::ForgetScene(const std::string& name) {
  {
    const std::lock_guard lock(mutex_);
    forgotten_.push_back(name);
  }
  queue_->Call();
}

std::vector<CacheReport> GlWorker::Caches() const {
  const std::lock_guard lock(mutex_);
  return caches_;
}

void GlWorker::Join() {
  if (thread_.joinable()) thread_.join();
}

}  // namespace halfshade
