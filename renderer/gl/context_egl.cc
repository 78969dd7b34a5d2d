#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
#include <glad/gl.h>

#include <array>

#include "renderer/gl/context_backends.h"
#include "renderer/gl/turn.h"
#include "renderer/status.h"

namespace halfshade::gl {
namespace {

// libEGL's entry points, opened once per process and never closed (drivers leave threads behind).
struct Egl {
  decltype(&eglGetProcAddress) GetProcAddress = nullptr;
  decltype(&eglQueryString) QueryString = nullptr;
  decltype(&eglInitialize) Initialize = nullptr;
  decltype(&eglBindAPI) BindAPI = nullptr;
  decltype(&eglChooseConfig) ChooseConfig = nullptr;
  decltype(&eglCreateContext) CreateContext = nullptr;
  decltype(&eglDestroyContext) DestroyContext = nullptr;
  decltype(&eglMakeCurrent) MakeCurrent = nullptr;
  decltype(&eglGetError) GetError = nullptr;
  PFNEGLQUERYDEVICESEXTPROC QueryDevices = nullptr;
  PFNEGLQUERYDEVICESTRINGEXTPROC QueryDeviceString = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC GetPlatformDisplay = nullptr;
};

absl::StatusOr<Egl> OpenEgl() {
  void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return absl::NotFoundError("libEGL.so.1 is not installed (Debian: libegl1)");
  Egl egl;
  const auto load = [library](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
    return function != nullptr;
  };
  if (!load(egl.GetProcAddress, "eglGetProcAddress") || !load(egl.QueryString, "eglQueryString") ||
      !load(egl.Initialize, "eglInitialize") || !load(egl.BindAPI, "eglBindAPI") ||
      !load(egl.ChooseConfig, "eglChooseConfig") || !load(egl.CreateContext, "eglCreateContext") ||
      !load(egl.DestroyContext, "eglDestroyContext") || !load(egl.MakeCurrent, "eglMakeCurrent") ||
      !load(egl.GetError, "eglGetError")) {
    return absl::FailedPreconditionError("libEGL.so.1 lacks EGL 1.4");
  }
  egl.QueryDevices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(egl.GetProcAddress("eglQueryDevicesEXT"));
  egl.QueryDeviceString =
      reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(egl.GetProcAddress("eglQueryDeviceStringEXT"));
  egl.GetPlatformDisplay =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(egl.GetProcAddress("eglGetPlatformDisplayEXT"));
  if (egl.GetPlatformDisplay == nullptr) return absl::FailedPreconditionError("EGL lacks EGL_EXT_platform_base");
  return egl;
}

const absl::StatusOr<Egl>& TheEgl() {
  static const absl::StatusOr<Egl>& egl = *new absl::StatusOr<Egl>(OpenEgl());
  return egl;
}

std::vector<EGLDeviceEXT> Devices(const Egl& egl) {
  EGLint count = 0;
  if (egl.QueryDevices == nullptr || egl.QueryDevices(0, nullptr, &count) != EGL_TRUE) return {};
  std::vector<EGLDeviceEXT> devices(size_t(std::max(count, 0)));
  if (egl.QueryDevices(count, devices.data(), &count) != EGL_TRUE) return {};
  devices.resize(size_t(count));
  return devices;
}

absl::Status EglFailure(const Egl& egl, const std::string& call) {
  std::array<char, 16> code{};
  std::snprintf(code.data(), code.size(), "0x%04x", unsigned(egl.GetError()));
  return absl::FailedPreconditionError(call + " failed with EGL error " + code.data());
}

class EglContext : public Context {
 public:
  static absl::StatusOr<std::unique_ptr<Context>> Make(const Egl& egl, EGLDisplay display, std::string description) {
    auto context = std::unique_ptr<EglContext>(new EglContext(egl, display));
    context->backend_ = Backend::kEgl;
    context->description_ = std::move(description);
    if (egl.BindAPI(EGL_OPENGL_API) != EGL_TRUE) return EglFailure(egl, "eglBindAPI(EGL_OPENGL_API)");
    // Surfaceless displays may offer no config for pbuffers; none is needed where EGL_KHR_no_config_context is there.
    const EGLint config_wish[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (egl.ChooseConfig(display, config_wish, &config, 1, &count) != EGL_TRUE || count == 0) config = nullptr;
    // The last pair, a loss that is told, is more than software drivers give.
    EGLint wish[] = {EGL_CONTEXT_MAJOR_VERSION,
                     4,
                     EGL_CONTEXT_MINOR_VERSION,
                     5,
                     EGL_CONTEXT_OPENGL_PROFILE_MASK,
                     EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                     EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY,
                     EGL_LOSE_CONTEXT_ON_RESET,
                     EGL_NONE};
    context->context_ = egl.CreateContext(display, config, EGL_NO_CONTEXT, wish);
    if (context->context_ == EGL_NO_CONTEXT) {
      wish[6] = EGL_NONE;
      context->context_ = egl.CreateContext(display, config, EGL_NO_CONTEXT, wish);
    }
    if (context->context_ == EGL_NO_CONTEXT) return EglFailure(egl, "eglCreateContext(4.5 core)");
    RETURN_IF_ERROR(context->MakeCurrent());
    RETURN_IF_ERROR(context->Load(egl.GetProcAddress));
    return context;
  }

  // The display stays: other contexts of the process may share it.
  ~EglContext() override {
    if (context_ == EGL_NO_CONTEXT) return;
    const Turn turn;
    ReleaseCurrent();
    egl_.DestroyContext(display_, context_);
  }

  absl::Status MakeCurrent() override {
    egl_.BindAPI(EGL_OPENGL_API);
    if (egl_.MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE) {
      return EglFailure(egl_, "eglMakeCurrent");
    }
    return absl::OkStatus();
  }

  void ReleaseCurrent() override { egl_.MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

 private:
  EglContext(const Egl& egl, EGLDisplay display) : egl_(egl), display_(display) {}
  const Egl& egl_;
  EGLDisplay display_;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

absl::StatusOr<std::vector<Candidate>> ListEgl() {
  const absl::StatusOr<Egl>& egl = TheEgl();
  RETURN_IF_ERROR(egl.status());
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < Devices(*egl).size(); ++i) {
    candidates.push_back({"EGL device " + std::to_string(i), int(i)});
  }
  candidates.push_back({"EGL surfaceless", -1});
  return candidates;
}

absl::StatusOr<std::unique_ptr<Context>> CreateEgl(const Candidate& candidate) {
  const absl::StatusOr<Egl>& egl = TheEgl();
  RETURN_IF_ERROR(egl.status());
  const Turn turn;
  EGLDisplay display = EGL_NO_DISPLAY;
  std::string description = candidate.name;
  if (candidate.egl_device >= 0) {
    const std::vector<EGLDeviceEXT> devices = Devices(*egl);
    if (size_t(candidate.egl_device) >= devices.size()) return absl::NotFoundError("there is no such device");
    const EGLDeviceEXT device = devices[candidate.egl_device];
    display = egl->GetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
    const char* extensions =
        egl->QueryDeviceString != nullptr ? egl->QueryDeviceString(device, EGL_EXTENSIONS) : nullptr;
    if (extensions != nullptr) description += std::string(" (") + extensions + ")";
  } else {
    display = egl->GetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  }
  if (display == EGL_NO_DISPLAY) return EglFailure(*egl, "eglGetPlatformDisplay");
  if (egl->Initialize(display, nullptr, nullptr) != EGL_TRUE) return EglFailure(*egl, "eglInitialize");
  return EglContext::Make(*egl, display, description);
}

}  // namespace halfshade::gl
