#include "renderer/light/sample_maps.h"

#include <glad/gl.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/fullscreen.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr int kMaxBatch = 64;                        // kMaxBatch of resolve_sample_maps.frag
constexpr uint64_t kBatchBytes = 64ull << 20;        // maps resolved by one pass
constexpr double kResolveNanosecondsPerSample = 12;  // per pixel; llvmpipe, two cores, measured high
constexpr double kResolveNanosecondsPerPixel = 15;
constexpr int kMapsUnit = kPlanesUnit + 1;

}  // namespace

absl::StatusOr<std::unique_ptr<SampleMaps>> SampleMaps::Create(const DrawContext& draw,
                                                               std::shared_ptr<const OccludersOnContext> occluders,
                                                               const AreaLight& light, std::vector<glm::dvec2> points,
                                                               int map_size, uint64_t max_bytes, Sides sides) {
  auto maps = std::make_unique<SampleMaps>();
  maps->occluders_ = std::move(occluders);
  maps->hull_ = maps->occluders_->hull();
  maps->light_ = light;
  maps->points_ = std::move(points);
  maps->map_size_ = map_size;
  const uint64_t map_bytes = 4ull * map_size * map_size;
  const int layers_that_fit = int(std::clamp<uint64_t>(kBatchBytes / map_bytes, 1, kMaxBatch));
  maps->layers_ = std::min(maps->point_count(), layers_that_fit);
  for (int side = sides == Sides::kAll ? 0 : 1; side < 5; ++side) {
    // The front batches come even without occluders: they count samples above the horizon.
    if (side > 0 && !maps->hull_.ReachesSide(side)) continue;
    const glm::dvec2 slope_per_texel = maps->SlopePerTexel(side);
    for (int first = 0; first < maps->point_count(); first += maps->layers_) {
      Batch& batch = maps->batches_.emplace_back();
      batch.side = side;
      batch.first_point = first;
      batch.point_count = std::min(maps->layers_, maps->point_count() - first);
      batch.slope_per_texel = slope_per_texel;
    }
  }
  const uint64_t batch_bytes = map_bytes * maps->layers_;
  uint64_t batches_kept = maps->batches_.size();
  if (batch_bytes * batches_kept > max_bytes) {
    batches_kept = (max_bytes - std::min(max_bytes, maps->occluders_->SizeBytes())) / batch_bytes;
  }
  for (Batch& batch : maps->batches_) {
    if (batches_kept == 0) {
      maps->maps_left_out_ += batch.point_count;
      continue;
    }
    --batches_kept;
    ASSIGN_OR_RETURN(batch.maps, maps->MakeLayers(draw));
    RETURN_IF_ERROR(maps->DrawBatch(draw, batch, batch.maps));
    maps->maps_kept_ += batch.point_count;
  }
  if (maps->maps_left_out_ == 0) maps->occluders_ = nullptr;
  return maps;
}

uint64_t SampleMaps::SizeBytes() const {
  uint64_t bytes = points_.size() * sizeof(glm::dvec2) + (occluders_ == nullptr ? 0 : occluders_->SizeBytes());
  for (const Batch& batch : batches_) bytes += batch.maps.SizeBytes();
  return bytes;
}

SampleMaps::FrontMap SampleMaps::front_map() const {
  const Batch& batch = batches_[0];
  assert(maps_left_out_ == 0 && batch.side == 0);
  const Window window = WindowOf(0, points_[0]);
  return {&batch.maps,           map_size_,      glm::dvec2(window.u0, window.v0) - 0.5 * batch.slope_per_texel,
          batch.slope_per_texel, hull_.z_near(), hull_.NeedsSideWindows() ? hull_.FrontSlope() : 0};
}

absl::StatusOr<gl::Texture> SampleMaps::MakeLayers(const DrawContext& draw) const {
  return gl::Texture::Create2DArray(*draw.context, GL_DEPTH_COMPONENT32F, map_size_, map_size_, layers_);
}

Window SampleMaps::WindowOf(int side, const glm::dvec2& point) const {
  if (side > 0) return {-1, 0, 1, 1 / kSideWindowSlope};
  const Window window = hull_.FrontWindow(point);
  return window.IsEmpty() ? Window{0, 0, 0, 0} : window;
}

glm::dvec2 SampleMaps::SlopePerTexel(int side) const {
  glm::dvec2 extent(0);
  for (const glm::dvec2& point : points_) {
    const Window window = WindowOf(side, point);
    // Occluders seen edge-on have no extent of their own.
    const double least = std::ldexp(std::max({1.0, std::abs(window.u0), std::abs(window.v0)}), -20);
    extent =
        glm::max(extent, glm::dvec2(std::max(window.u1 - window.u0, least), std::max(window.v1 - window.v0, least)));
  }
  return extent / double(map_size_ - 2);
}

absl::Status SampleMaps::DrawLayer(const DrawContext& draw, const Batch& batch, const gl::Texture& maps,
                                   int layer) const {
  const GladGLContext& gl = draw.context->gl();
  ASSIGN_OR_RETURN(gl::Framebuffer framebuffer, gl::Framebuffer::CreateDepthLayer(*draw.context, maps, layer));
  framebuffer.Bind();
  gl.Viewport(0, 0, map_size_, map_size_);
  const float empty = 0;
  gl.ClearBufferfv(GL_DEPTH, 0, &empty);
  const glm::dvec2& point = points_[batch.first_point + layer];
  const Window window = WindowOf(batch.side, point);
  const glm::dvec2 corner = glm::dvec2(window.u0, window.v0) - batch.slope_per_texel;
  return occluders_->DrawDepth(draw, batch.side, point, glm::dvec4(corner, 1.0 / batch.slope_per_texel), map_size_);
}

absl::Status SampleMaps::DrawBatch(const DrawContext& draw, const Batch& batch, const gl::Texture& maps) const {
  const GladGLContext& gl = draw.context->gl();
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_GREATER);
  gl.DepthMask(GL_TRUE);
  gl.Disable(GL_CULL_FACE);
  gl.Disable(GL_BLEND);
  gl.Enable(GL_DEPTH_CLAMP);  // what is nearer than z_near occludes too, as if it stood there
  absl::Status status;
  for (int layer = 0; layer < batch.point_count && status.ok(); ++layer) status = DrawLayer(draw, batch, maps, layer);
  gl.Disable(GL_DEPTH_CLAMP);  // no other pass expects it, whatever stopped this one
  RETURN_IF_ERROR(status);
  return draw.context->Check("light/depth");
}

absl::Status SampleMaps::ResolveBatch(const DrawContext& draw, const Batch& batch, const gl::Texture& maps,
                                      const Receivers& receivers) const {
  const bool shares_half_space = hull_.NeedsSideWindows();
  ASSIGN_OR_RETURN(gl::Program * program,
                   draw.programs->Get(
                       "common/fullscreen.vert", "light/resolve_sample_maps.frag",
                       shares_half_space ? std::vector<std::string>{"SHARES_HALF_SPACE"} : std::vector<std::string>{}));
  program->Use();
  SetReceivers(*program, receivers, light_);
  maps.Bind(kMapsUnit);
  std::vector<glm::vec4> samples;
  for (int layer = 0; layer < batch.point_count; ++layer) {
    const glm::dvec2& point = points_[batch.first_point + layer];
    const Window window = WindowOf(batch.side, point);
    // The border's texel is the first; its centre is half of one before the window.
    samples.emplace_back(glm::dvec4(point, glm::dvec2(window.u0, window.v0) - 0.5 * batch.slope_per_texel));
  }
  program->Set("maps", kMapsUnit);
  program->Set("sample_count", batch.point_count);
  program->Set("samples", samples);
  program->Set("slope_per_texel", glm::vec2(batch.slope_per_texel));
  program->Set("z_near", float(hull_.z_near()));
  program->Set("map_size", float(map_size_));
  if (shares_half_space) {
    program->Set("map_from_light", glm::mat3(MapFromLight(batch.side)));
    program->Set("side", batch.side);
    program->Set("front_slope", float(hull_.FrontSlope()));
  }
  return DrawFullscreen(draw, receivers.width, receivers.height,
                        kResolveNanosecondsPerPixel + kResolveNanosecondsPerSample * batch.point_count);
}

absl::StatusOr<gl::Texture> SampleMaps::CountHidden(const DrawContext& draw, const Receivers& receivers) const {
  const GladGLContext& gl = draw.context->gl();
  ASSIGN_OR_RETURN(gl::Texture sums, gl::Texture::Create2D(*draw.context, GL_RG32F, receivers.width, receivers.height));
  ASSIGN_OR_RETURN(gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw.context, {&sums}));
  gl::Texture scratch;
  for (size_t i = 0; i < batches_.size(); ++i) {
    const Batch& batch = batches_[i];
    const gl::Texture* maps = &batch.maps;
    if (!*maps) {
      if (!scratch) {
        ASSIGN_OR_RETURN(scratch, MakeLayers(draw));
      }
      RETURN_IF_ERROR(DrawBatch(draw, batch, scratch));
      maps = &scratch;
    }
    framebuffer.Bind();
    gl.Viewport(0, 0, receivers.width, receivers.height);
    gl.Disable(GL_DEPTH_TEST);
    // Whole numbers: exact in any order up to 2^24 samples.
    if (i == 0) {
      gl.Disable(GL_BLEND);
    } else {
      gl.Enable(GL_BLEND);
      gl.BlendFunc(GL_ONE, GL_ONE);
    }
    RETURN_IF_ERROR(ResolveBatch(draw, batch, *maps, receivers));
  }
  gl.Disable(GL_BLEND);
  RETURN_IF_ERROR(draw.context->Check("light/resolve_sample_maps"));
  return sums;
}

}  // namespace halfshade
