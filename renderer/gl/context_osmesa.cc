#include <glad/gl.h>
// After glad, whose types it uses.
#include <GL/osmesa.h>
#include <dlfcn.h>

#include <array>

#include "renderer/gl/context_backends.h"
#include "renderer/gl/turn.h"
#include "renderer/status.h"

namespace halfshade::gl {
namespace {

// libOSMesa's entry points, opened once per process and never closed.
struct Osmesa {
  decltype(&OSMesaCreateContextAttribs) CreateContextAttribs = nullptr;
  decltype(&OSMesaMakeCurrent) MakeCurrent = nullptr;
  decltype(&OSMesaDestroyContext) DestroyContext = nullptr;
  decltype(&OSMesaGetProcAddress) GetProcAddress = nullptr;
};

absl::StatusOr<Osmesa> OpenOsmesa() {
  // RTLD_DEEPBIND is not used: both Mesa libraries keep their own symbols with RTLD_LOCAL.
  void* library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return absl::NotFoundError("libOSMesa.so.8 is not installed (Debian: libosmesa6)");
  Osmesa osmesa;
  const auto load = [library](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
    return function != nullptr;
  };
  if (!load(osmesa.CreateContextAttribs, "OSMesaCreateContextAttribs") ||
      !load(osmesa.MakeCurrent, "OSMesaMakeCurrent") || !load(osmesa.DestroyContext, "OSMesaDestroyContext") ||
      !load(osmesa.GetProcAddress, "OSMesaGetProcAddress")) {
    return absl::FailedPreconditionError("libOSMesa.so.8 lacks OSMesaCreateContextAttribs");
  }
  return osmesa;
}

const absl::StatusOr<Osmesa>& TheOsmesa() {
  static const absl::StatusOr<Osmesa>& osmesa = *new absl::StatusOr<Osmesa>(OpenOsmesa());
  return osmesa;
}

class OsmesaContext : public Context {
 public:
  static absl::StatusOr<std::unique_ptr<Context>> Make(const Osmesa& osmesa) {
    auto context = std::unique_ptr<OsmesaContext>(new OsmesaContext(osmesa));
    context->backend_ = Backend::kOsmesa;
    context->description_ = "OSMesa";
    const int wish[] = {OSMESA_FORMAT,
                        OSMESA_RGBA,
                        OSMESA_PROFILE,
                        OSMESA_CORE_PROFILE,
                        OSMESA_CONTEXT_MAJOR_VERSION,
                        4,
                        OSMESA_CONTEXT_MINOR_VERSION,
                        5,
                        0};
    context->context_ = osmesa.CreateContextAttribs(wish, nullptr);
    if (context->context_ == nullptr) return absl::FailedPreconditionError("OSMesa gives no 4.5 core context");
    RETURN_IF_ERROR(context->MakeCurrent());
    RETURN_IF_ERROR(context->Load(osmesa.GetProcAddress));
    return context;
  }

  ~OsmesaContext() override {
    const Turn turn;
    if (context_ != nullptr) osmesa_.DestroyContext(context_);
  }

  absl::Status MakeCurrent() override {
    if (osmesa_.MakeCurrent(context_, pixel_.data(), GL_UNSIGNED_BYTE, 1, 1) != GL_TRUE) {
      return absl::FailedPreconditionError("OSMesaMakeCurrent failed");
    }
    return absl::OkStatus();
  }

  void ReleaseCurrent() override { osmesa_.MakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }

 private:
  explicit OsmesaContext(const Osmesa& osmesa) : osmesa_(osmesa) {}
  const Osmesa& osmesa_;
  OSMesaContext context_ = nullptr;
  std::array<unsigned char, 4> pixel_{};  // OSMesa wants a default framebuffer; nothing draws into it
};

}  // namespace

absl::StatusOr<std::unique_ptr<Context>> CreateOsmesa() {
  const absl::StatusOr<Osmesa>& osmesa = TheOsmesa();
  RETURN_IF_ERROR(osmesa.status());
  const Turn turn;
  return OsmesaContext::Make(*osmesa);
}

}  // namespace halfshade::gl
