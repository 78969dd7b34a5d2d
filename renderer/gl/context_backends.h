// The ways to a context that context.cc chooses from. Each opens its library at run time, so that a program starts, and
// can say what to install, where one of them is missing.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>
#include <vector>

#include "renderer/gl/context.h"

namespace halfshade::gl {

// One thing that can be tried.
struct Candidate {
  std::string name;     // "EGL device 0", "EGL surfaceless", "OSMesa"
  int egl_device = -1;  // -1: surfaceless
};

// Every EGL device in order, then surfaceless; or a status that says why there is none.
absl::StatusOr<std::vector<Candidate>> ListEgl();
absl::StatusOr<std::unique_ptr<Context>> CreateEgl(const Candidate& candidate);
absl::StatusOr<std::unique_ptr<Context>> CreateOsmesa();

}  // namespace halfshade::gl
