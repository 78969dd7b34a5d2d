#include "server/gl_worker.h"

#include <chrono>
#include <future>

#include "renderer/calibrate.h"
#include "renderer/scene_loader/decode_image.h"
#include "renderer/status.h"

namespace halfshade {

RendererFactory MakeGlRendererFactory(const gl::ContextOptions& options, uint64_t max_texture_pixels,
                                      const ContextMemory& memory) {
  return [options, max_texture_pixels, memory]() -> absl::StatusOr<WorkerRenderer> {
    WorkerRenderer worker;
    ASSIGN_OR_RETURN(worker.context, gl::Context::Create(options));
    ASSIGN_OR_RETURN(worker.renderer, Renderer::Create(
                                          worker.context.get(),
                                          [max_texture_pixels](const EncodedImage& image) {
                                            return DecodeImage(image, max_texture_pixels);
                                          },
                                          memory));
    worker.gl_renderer = worker.context->renderer();
    worker.gl_version = worker.context->version();
    worker.description = worker.context->description();
    ASSIGN_OR_RETURN(worker.slowness, MeasureSlowness(*worker.renderer));
    return worker;
  };
}

absl::StatusOr<std::unique_ptr<GlWorker>> GlWorker::Start(const RendererFactory& factory, RenderQueue* queue) {
  std::promise<absl::StatusOr<WorkerRenderer>> started;
  auto worker = std::unique_ptr<GlWorker>(new GlWorker(queue));
  worker->thread_ = std::thread([&factory, &started, self = worker.get()] {
    absl::StatusOr<WorkerRenderer> made = factory();
    if (!made.ok()) {
      started.set_value(made.status());
      return;
    }
    WorkerRenderer own = *std::move(made);
    WorkerRenderer words;
    words.gl_renderer = own.gl_renderer;
    words.gl_version = own.gl_version;
    words.description = own.description;
    words.slowness = own.slowness;
    started.set_value(std::move(words));  // the references are gone from here on
    self->Work(own);
  });
  ASSIGN_OR_RETURN(worker->info_, started.get_future().get());
  return worker;
}

void GlWorker::Work(WorkerRenderer& own) {
  const auto is_called = [this] {
    const std::lock_guard lock(mutex_);
    return !forgotten_.empty();
  };
  while (std::optional<RenderJob> job = queue_->Pop(is_called)) {
    if (job->run) {
      const auto begin = std::chrono::steady_clock::now();
      job->run(own);
      queue_->Report(std::chrono::steady_clock::now() - begin);
    }
    if (own.renderer != nullptr) Tidy(*own.renderer);
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
