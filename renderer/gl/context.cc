#include "renderer/gl/context.h"

#include <glad/gl.h>

#include "renderer/gl/context_backends.h"
#include "renderer/status.h"

namespace halfshade::gl {
namespace {

void GLAD_API_PTR KeepFirstError(GLenum, GLenum type, GLuint, GLenum severity, GLsizei, const GLchar* message,
                                 const void* first_error) {
  if (type != GL_DEBUG_TYPE_ERROR && severity != GL_DEBUG_SEVERITY_HIGH) return;
  // The callback is synchronous, on the context's thread; the string belongs to the context that the pointer came from.
  auto& first = *static_cast<std::string*>(const_cast<void*>(first_error));
  if (first.empty()) first = message;
}

const char* ErrorName(GLenum error) {
  switch (error) {
    case GL_INVALID_ENUM:
      return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
      return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
      return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
      return "GL_OUT_OF_MEMORY";
    case GL_CONTEXT_LOST:
      return "GL_CONTEXT_LOST";
    default:
      return "unknown GL error";
  }
}

// Tries one way after the other; `attempts` gets a line for each.
absl::StatusOr<std::unique_ptr<Context>> TryAll(const ContextOptions& options, std::string& attempts) {
  const auto failed = [&attempts](const std::string& name, const absl::Status& status) {
    attempts += "\n  " + name + ": " + std::string(status.message());
  };
  if (options.backend != Backend::kOsmesa) {
    const auto candidates = ListEgl();
    if (!candidates.ok()) failed("EGL", candidates.status());
    bool is_found = false;
    for (size_t i = 0; candidates.ok() && i < candidates->size(); ++i) {
      const Candidate& candidate = (*candidates)[i];
      if (options.egl_device >= 0 && candidate.egl_device != options.egl_device) continue;
      is_found = true;
      auto context = CreateEgl(candidate);
      if (context.ok()) return context;
      failed(candidate.name, context.status());
    }
    if (candidates.ok() && !is_found) {
      failed("EGL device " + std::to_string(options.egl_device),
             absl::NotFoundError("there are " + std::to_string(candidates->size() - 1) + " devices"));
    }
  }
  if (options.backend != Backend::kEgl) {
    auto context = CreateOsmesa();
    if (context.ok()) return context;
    failed("OSMesa", context.status());
  }
  return absl::FailedPreconditionError("no OpenGL 4.5 core context; tried" + attempts);
}

DoctorLine Describe(const std::string& name, const absl::StatusOr<std::unique_ptr<Context>>& context) {
  if (!context.ok()) return {name, false, std::string(context.status().message())};
  return {name, true, (*context)->renderer() + ", OpenGL " + (*context)->version()};
}

}  // namespace

Context::Context() : gl_(std::make_unique<GladGLContext>()) {}
Context::~Context() = default;

absl::Status Context::Load(void (*(*get_proc_address)(const char*))()) {
  if (gladLoadGLContext(gl_.get(), get_proc_address) == 0) {
    return absl::FailedPreconditionError("the functions of OpenGL 4.5 are not all there");
  }
  renderer_ = reinterpret_cast<const char*>(gl_->GetString(GL_RENDERER));
  version_ = reinterpret_cast<const char*>(gl_->GetString(GL_VERSION));
  is_software_ = renderer_.find("llvmpipe") != std::string::npos || renderer_.find("softpipe") != std::string::npos;
  if (gl_->ClipControl == nullptr) {
    return absl::FailedPreconditionError(renderer_ + " gives OpenGL " + version_ + "; 4.5 is needed");
  }
  gl_->Enable(GL_DEBUG_OUTPUT);
  gl_->Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  gl_->DebugMessageCallback(KeepFirstError, &first_debug_error_);
  gl_->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl_->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_->Disable(GL_DITHER);
  return Check("creating the context");
}

absl::StatusOr<std::unique_ptr<Context>> Context::Create(const ContextOptions& options) {
  std::string attempts;
  return TryAll(options, attempts);
}

void Context::InjectError(unsigned error, int checks) {
  injected_error_ = error;
  checks_to_injected_error_ = checks;
}

unsigned Context::TakeInjectedError() const {
  if (checks_to_injected_error_ < 0) return GL_NO_ERROR;
  return checks_to_injected_error_.fetch_sub(1) == 0 ? injected_error_.load() : unsigned(GL_NO_ERROR);
}

absl::Status Context::Check(const char* pass) const {
  GLenum error = gl_->GetError();
  if (error == GL_NO_ERROR) error = TakeInjectedError();
  const std::string debug_error = std::exchange(first_debug_error_, {});
  const bool tells_reset = gl_->GetGraphicsResetStatus != nullptr;
  if (error == GL_CONTEXT_LOST || (tells_reset && gl_->GetGraphicsResetStatus() != GL_NO_ERROR)) is_lost_ = true;
  if (is_lost_) return absl::UnavailableError(std::string(pass) + ": the GL context is lost");
  if (error == GL_NO_ERROR && debug_error.empty()) return absl::OkStatus();
  for (int i = 0; i < 16 && gl_->GetError() != GL_NO_ERROR; ++i) {
  }
  std::string message = std::string(pass) + ": ";
  if (error != GL_NO_ERROR) message += ErrorName(error);
  if (!debug_error.empty()) message += (error != GL_NO_ERROR ? ": " : "") + debug_error;
  return error == GL_OUT_OF_MEMORY ? absl::ResourceExhaustedError(message) : absl::InternalError(message);
}

std::vector<DoctorLine> Diagnose() {
  std::vector<DoctorLine> lines;
  const auto candidates = ListEgl();
  if (!candidates.ok()) lines.push_back({"EGL", false, std::string(candidates.status().message())});
  for (size_t i = 0; candidates.ok() && i < candidates->size(); ++i) {
    lines.push_back(Describe((*candidates)[i].name, CreateEgl((*candidates)[i])));
  }
  lines.push_back(Describe("OSMesa", CreateOsmesa()));
  return lines;
}

}  // namespace halfshade::gl
