// From a lit sample of FRAME to its share of the picture: shadow catcher, tone curve, mean over the samples.
#pragma once

#include <absl/status/statusor.h>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/texture.h"
#include "renderer/request.h"

namespace halfshade {

// The samples of one pixel are each tone-mapped, and then averaged: an edge between something far brighter than the
// display and something dark is as smooth as any other. Not thread-safe; samples are added in the order of the plan.
class FrameSamples {
 public:
  // The request's frame is what StartFrame and AddLight leave: one sample, no curve, no catcher.
  static bool AreNeeded(const RenderRequest& request);

  // Of a catcher's ground, which a G-buffer's object_ids know as ground_id.
  struct Catcher {
    const gl::Texture* unshadowed = nullptr;  // the frame without any occluder
    const gl::Texture* object_ids = nullptr;
    uint32_t ground_id = 0;
  };
  // Adds one of request.samples samples. `catcher` where the request's ground is one.
  absl::Status Add(const DrawContext& draw, const gl::Texture& frame, const Catcher* catcher,
                   const RenderRequest& request);

  // RGBA32F, when all samples are added.
  gl::Texture Take() { return std::move(sum_); }

 private:
  gl::Texture sum_;
};

}  // namespace halfshade
