#include "server/gl_worker.h"

#include <chrono>
#include <future>

#include "renderer/scene_loader/decode_image.h"
#include "renderer/status.h"

namespace halfshade {

RendererFactory MakeGlRendererFactory(const gl::ContextOptions& options, uint64_t max_texture_pixels) {
  return [options, max_texture_pixels]() -> absl::StatusOr<WorkerRenderer> {
    WorkerRenderer worker;
    ASSIGN_OR_RETURN(worker.context, gl::Context::Create(options));
    ASSIGN_OR_RETURN(worker.renderer,
                     Renderer::Create(worker.context.get(), [max_texture_pixels](const EncodedImage& image) {
                       return DecodeImage(image, max_texture_pixels);
                     }));
    worker.gl_renderer = worker.context->renderer();
    worker.gl_version = worker.context->version();
    worker.description = worker.context->description();
    return worker;
  };
}

absl::StatusOr<std::unique_ptr<GlWorker>> GlWorker::Start(const RendererFactory& factory, RenderQueue* queue) {
  std::promise<absl::StatusOr<WorkerRenderer>> started;
  auto worker = std::unique_ptr<GlWorker>(new GlWorker);
  worker->thread_ = std::thread([&factory, &started, queue] {
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
    started.set_value(std::move(words));  // the references are gone from here on
    while (std::optional<RenderJob> job = queue->Pop()) {
      const auto begin = std::chrono::steady_clock::now();
      job->run(own);
      queue->Report(std::chrono::steady_clock::now() - begin);
    }
  });
  ASSIGN_OR_RETURN(worker->info_, started.get_future().get());
  return worker;
}

GlWorker::~GlWorker() {
  if (thread_.joinable()) thread_.join();
}

}  // namespace halfshade
