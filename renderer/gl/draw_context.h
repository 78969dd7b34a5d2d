// What every pass needs to draw: the context, its programs and the bound on its submissions.
#pragma once

#include "renderer/gl/context.h"
#include "renderer/gl/pacer.h"
#include "renderer/gl/program.h"

namespace halfshade {

struct DrawContext {
  gl::Context* context = nullptr;
  gl::ProgramCache* programs = nullptr;
  gl::Pacer* pacer = nullptr;
};

}  // namespace halfshade
