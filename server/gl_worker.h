// One thread with one GL context and its renderer, working off the render queue.
#pragma once

#include <absl/status/statusor.h>

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "renderer/gl/context.h"
#include "renderer/renderer.h"
#include "server/admission.h"

namespace halfshade {

// A renderer with the context that it draws on, and that context's words for itself.
struct WorkerRenderer {
  std::unique_ptr<gl::Context> context;  // null for a fake; destroyed after the renderer
  std::unique_ptr<Renderer> renderer;
  std::string gl_renderer;
  std::string gl_version;
  std::string description;
  Machine machine;
};

// Called on the worker's own thread, where the context stays current; again when a context is lost.
using RendererFactory = std::function<absl::StatusOr<WorkerRenderer>()>;

// The real one: a context by `options`, warmed up and timed.
RendererFactory MakeGlRendererFactory(const gl::ContextOptions& options, const ImageDecoder& decoder,
                                      const ContextMemory& memory);

struct ContextWatch {
  std::chrono::milliseconds canary{10'000};                   // of idleness, then the context shows that it draws
  std::function<void(bool is_well)> on_health = [](bool) {};  // on the worker's thread: false, and true again
};

// A context whose jobs end INTERNAL or UNAVAILABLE, or which had nothing to do for ContextWatch::canary, draws its
// canary. Where that fails the context is given up and made anew, again and again, until the queue is closed; nothing
// runs there meanwhile.
class GlWorker {
 public:
  // Starts the thread and waits for its renderer; the factory's error. `queue` outlives the worker.
  static absl::StatusOr<std::unique_ptr<GlWorker>> Start(const RendererFactory& factory, RenderQueue* queue,
                                                         const ContextWatch& watch = {});
  ~GlWorker() { Join(); }
  // Waits for the end of the thread. Close the queue first, or this waits for ever.
  void Join();

  const std::string& gl_renderer() const { return info_.gl_renderer; }
  const std::string& gl_version() const { return info_.gl_version; }
  const std::string& description() const { return info_.description; }
  const Machine& machine() const { return info_.machine; }

  // From any thread: frees what stays of a scene on this context, after the render under way, before the next one.
  void ForgetScene(const std::string& name);
  // From any thread: Renderer::Caches as they were after the last render.
  std::vector<CacheReport> Caches() const;

 private:
  GlWorker(RendererFactory factory, RenderQueue* queue, ContextWatch watch)
      : factory_(std::move(factory)), queue_(queue), watch_(std::move(watch)) {}
  void Work(WorkerRenderer own);  // until the queue is closed and empty
  void Tidy(Renderer& renderer);  // forgets what is to be forgotten, and counts what is left
  // Another context in the place of one that failed. False: the queue was closed first.
  bool Rebuild(WorkerRenderer* own);

  const RendererFactory factory_;
  RenderQueue* const queue_;
  const ContextWatch watch_;
  WorkerRenderer info_;  // words and machine alone; context and renderer live on the thread
  mutable std::mutex mutex_;
  std::vector<std::string> forgotten_;
  std::vector<CacheReport> caches_;
  std::thread thread_;
};

}  // namespace halfshade
