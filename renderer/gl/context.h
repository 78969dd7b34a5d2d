// The door to GL: a 4.5 core context on EGL (device platform, then surfaceless) or OSMesa, chosen at run time.
//
// One context belongs to one thread; contexts of both kinds may live in one process. Each holds its own glad function
// table; everything in this room calls GL through it.
#pragma once

#include <absl/status/statusor.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

// Forward of glad's table (glad/gl.h is included by the .cc files and by the GL rooms).
struct GladGLContext;

namespace halfshade::gl {

enum class Backend { kAuto, kEgl, kOsmesa };

struct ContextOptions {
  Backend backend = Backend::kAuto;  // kAuto: EGL, then OSMesa
  int egl_device = -1;               // index into eglQueryDevicesEXT; -1: every device in order, then surfaceless
};

class Context {
 public:
  // Makes a context and makes it current on the calling thread. FAILED_PRECONDITION listing everything that was tried
  // and why each failed.
  static absl::StatusOr<std::unique_ptr<Context>> Create(const ContextOptions& options);
  virtual ~Context();

  virtual absl::Status MakeCurrent() = 0;  // on the calling thread
  virtual void ReleaseCurrent() = 0;

  const GladGLContext& gl() const { return *gl_; }
  Backend backend() const { return backend_; }                     // never kAuto
  const std::string& renderer() const { return renderer_; }        // GL_RENDERER
  const std::string& version() const { return version_; }          // GL_VERSION
  const std::string& description() const { return description_; }  // "EGL device 0 (EGL_MESA_device_software)"
  bool IsSoftware() const { return is_software_; }                 // llvmpipe or softpipe

  // The one error check: glGetError, the first KHR_debug error message since the last call, and the reset status where
  // the driver tells it. `pass` names the pass in the error: INTERNAL; RESOURCE_EXHAUSTED where GL is out of memory;
  // UNAVAILABLE from a loss of the context on, after which only its destructor makes sense. Once a pass, in every
  // build.
  absl::Status Check(const char* pass) const;
  bool IsLost() const { return is_lost_; }

  // Fault injection, from any thread: Check reports `error` (GL_OUT_OF_MEMORY, GL_CONTEXT_LOST, ...), once, after
  // `checks` more that it does not touch.
  void InjectError(unsigned error, int checks = 0);

 protected:
  Context();
  // Loads the table, reads the strings, installs the debug callback and the state that every pass relies on:
  // glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE). The context is current. `get_proc_address` is EGL's or OSMesa's.
  absl::Status Load(void (*(*get_proc_address)(const char*))());

  std::unique_ptr<GladGLContext> gl_;
  Backend backend_ = Backend::kAuto;
  std::string renderer_;
  std::string version_;
  std::string description_;
  bool is_software_ = false;
  mutable std::string first_debug_error_;

 private:
  unsigned TakeInjectedError() const;

  mutable std::atomic<bool> is_lost_{false};
  std::atomic<unsigned> injected_error_{0};
  mutable std::atomic<int> checks_to_injected_error_{-1};  // -1: none is to come
};

// One line per thing tried, for `halfshade doctor`.
struct DoctorLine {
  std::string what;  // "EGL device 0", "EGL surfaceless", "OSMesa"
  bool is_ok = false;
  std::string detail;  // GL_RENDERER and version, or why it failed and what to do
};
// Tries every way to get a context, one after the other, and leaves none behind.
std::vector<DoctorLine> Diagnose();

// CPUs that this process may use: of its affinity and its cgroup's quota, rounded down, at least 1.
int AvailableCpus();

// Sets LP_NUM_THREADS to max(1, AvailableCpus() / contexts) unless the user has set it. Call before the
// first context of the process and before any thread is started.
void LimitDriverThreads(int contexts);

}  // namespace halfshade::gl
