#include "renderer/shadow/ssm/scatter.h"

#include <glad/gl.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/depth_pyramid.h"
#include "renderer/light/fullscreen.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// llvmpipe, two cores, measured high.
constexpr double kMillisecondsPerPatch = 1e-3;
constexpr double kMillisecondsPerTexel = 6e-6;
constexpr double kNanosecondsPerAddition = 4;
constexpr int kReceiversUnit = 0, kBatchUnit = 1;
constexpr GLuint kPatchesBinding = 2, kRangesBinding = 3;
constexpr int kVerticesPerPatch = 6;

// A patch as the shader reads it: column, row, w, covered share of its area.
using Patch = glm::vec4;

std::vector<Patch> ListPatches(const BinnedMap& map) {
  std::vector<Patch> patches;
  const int side = map.texels_per_patch;
  for (int row = 0; row < map.map_size / side; ++row) {
    for (int column = 0; column < map.map_size / side; ++column) {
      double sum = 0;
      int covered = 0;
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
          const float depth = map.depths[size_t(row * side + y) * map.map_size + column * side + x];
          sum += depth;
          covered += depth > 0;
        }
      }
      if (covered == 0) continue;
      patches.emplace_back(column, row, sum / covered / map.z_near, float(covered) / float(side * side));
    }
  }
  return patches;
}

class Scatterer {
 public:
  Scatterer(const DrawContext& draw, const BinnedMap& map, const glm::dvec2& half_edges,
            const ScatterReceivers& receivers)
      : draw_(draw),
        gl_(draw.context->gl()),
        map_(map),
        half_edges_(half_edges),
        receivers_(receivers),
        patch_slope_(map.slope_per_texel * double(map.texels_per_patch)),
        patches_(ListPatches(map)) {}

  absl::StatusOr<ScatterSums> Run(SsmBlend blend) {
    ScatterSums sums;
    const int size = receivers_.size;
    sums.hidden.resize(size_t(size) * size);
    sums.patches = patches_.size();
    sums.least_width = LeastWidth();
    if (patches_.empty() || receivers_.least_w == 0) return sums;
    const GLenum format = blend == SsmBlend::kFp32 ? GL_R32F : GL_R16F;
    ASSIGN_OR_RETURN(const gl::Texture total, gl::Texture::Create2D(*draw_.context, format, size, size));
    ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw_.context, {&total}));
    ASSIGN_OR_RETURN(const gl::Buffer patches, gl::Buffer::Create(*draw_.context, patches_));
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kPatchesBinding, patches.id());
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kRangesBinding, receivers_.ranges.id());
    const gl::VertexArray no_attributes = gl::VertexArray::Create(*draw_.context);
    vertex_array_ = no_attributes.id();
    Clear(framebuffer);
    gl_.Viewport(0, 0, size, size);
    gl_.Disable(GL_DEPTH_TEST);
    gl_.Enable(GL_BLEND);
    gl_.BlendFunc(GL_ONE, GL_ONE);
    const absl::Status status =
        blend == SsmBlend::kFp16Batched ? DrawBatches(framebuffer) : DrawPatches(framebuffer, 0, patches_.size());
    gl_.Disable(GL_SCISSOR_TEST);
    gl_.Disable(GL_BLEND);
    RETURN_IF_ERROR(status);
    RETURN_IF_ERROR(total.ReadFloats(sums.hidden.data(), sums.hidden.size()));
    RETURN_IF_ERROR(draw_.context->Check("ssm/scatter"));
    return sums;
  }

 private:
  // Ahead of the furthest receiver, in w.
  double AheadOf(const Patch& patch) const { return std::max(double(patch.z) - receivers_.least_w, 0.0); }

  double LeastWidth() const {
    double widest = 0;
    for (const Patch& patch : patches_) widest = std::max(widest, AheadOf(patch));
    double least = 1;
    for (int axis = 0; axis < 2; ++axis) {
      const double window = 2 * half_edges_[axis] * widest;
      if (window > patch_slope_[axis]) least = std::min(least, patch_slope_[axis] / window);
    }
    return least;
  }

  // Texels of its penumbra extent, at most.
  double MostTexels(const Patch& patch) const {
    const double texels_per_slope = receivers_.size / (receivers_.window.z - receivers_.window.x);
    const glm::dvec2 extent = patch_slope_ + (2.0 * half_edges_ + glm::abs(map_.point)) * AheadOf(patch);
    const glm::dvec2 texels = glm::min(extent * texels_per_slope + 1.0, glm::dvec2(receivers_.size));
    return texels.x * texels.y;
  }

  void Clear(const gl::Framebuffer& framebuffer) const {
    framebuffer.Bind();
    const float zeros[4] = {};
    gl_.ClearBufferfv(GL_COLOR, 0, zeros);
  }

  absl::StatusOr<gl::Program*> UseProgram() const {
    ASSIGN_OR_RETURN(gl::Program * program, draw_.programs->Get("ssm/scatter.vert", "ssm/scatter.frag"));
    program->Use();
    receivers_.w_on_gl.Bind(kReceiversUnit);
    program->Set("receivers", kReceiversUnit);
    program->Set("map_size", receivers_.size);
    program->Set("window_low", glm::vec2(receivers_.window));
    program->Set("slope_per_texel", float((receivers_.window.z - receivers_.window.x) / receivers_.size));
    program->Set("least_w", receivers_.least_w);
    program->Set("base_side", receivers_.base_side);
    program->Set("light_point", glm::vec2(map_.point));
    program->Set("half_edges", glm::vec2(half_edges_));
    program->Set("first_edge", glm::vec2(map_.first_center - 0.5 * map_.slope_per_texel));
    program->Set("slope_per_patch", glm::vec2(patch_slope_));
    return program;
  }

  // Blends patches [first, end) into the framebuffer, in bands of rows so small that no patch is over the bound alone.
  absl::Status DrawPatches(const gl::Framebuffer& framebuffer, size_t first, size_t end) const {
    RETURN_IF_ERROR(UseProgram().status());
    framebuffer.Bind();
    gl_.BindVertexArray(vertex_array_);
    const int size = receivers_.size;
    const int band =
        int(std::clamp(gl::Pacer::kMaxSubmissionMs / 2 / (kMillisecondsPerTexel * size), 1.0, double(size)));
    gl_.Enable(GL_SCISSOR_TEST);
    for (int row = 0; row < size; row += band) {
      const double most_texels = double(std::min(band, size - row)) * size;
      gl_.Scissor(0, row, size, std::min(band, size - row));
      for (size_t from = first; from < end;) {
        double predicted_ms = 0;
        size_t to = from;
        for (; to < end; ++to) {
          const double ms =
              kMillisecondsPerPatch + kMillisecondsPerTexel * std::min(MostTexels(patches_[to]), most_texels);
          if (to > from && predicted_ms + ms > gl::Pacer::kMaxSubmissionMs) break;
          predicted_ms += ms;
        }
        RETURN_IF_ERROR(draw_.pacer->Charge(predicted_ms));
        gl_.DrawArrays(GL_TRIANGLES, GLint(from * kVerticesPerPatch), GLsizei((to - from) * kVerticesPerPatch));
        from = to;
      }
    }
    gl_.Disable(GL_SCISSOR_TEST);
    return absl::OkStatus();
  }

  // floor(sqrt(P)) batches, blended from zero each and then added: sums of numbers that are more alike.
  absl::Status DrawBatches(const gl::Framebuffer& total) const {
    const int size = receivers_.size;
    ASSIGN_OR_RETURN(const gl::Texture batch, gl::Texture::Create2D(*draw_.context, GL_R16F, size, size));
    ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw_.context, {&batch}));
    ASSIGN_OR_RETURN(gl::Program * add, draw_.programs->Get("common/fullscreen.vert", "ssm/add_batch.frag"));
    const auto batches = size_t(std::sqrt(double(patches_.size())));
    for (size_t i = 0; i < batches; ++i) {
      Clear(framebuffer);
      RETURN_IF_ERROR(DrawPatches(framebuffer, patches_.size() * i / batches, patches_.size() * (i + 1) / batches));
      total.Bind();
      add->Use();
      batch.Bind(kBatchUnit);
      add->Set("batch", kBatchUnit);
      RETURN_IF_ERROR(DrawFullscreen(draw_, size, size, kNanosecondsPerAddition));
    }
    return absl::OkStatus();
  }

  const DrawContext& draw_;
  const GladGLContext& gl_;
  const BinnedMap& map_;
  const glm::dvec2 half_edges_;
  const ScatterReceivers& receivers_;
  const glm::dvec2 patch_slope_;
  const std::vector<Patch> patches_;
  GLuint vertex_array_ = 0;
};

}  // namespace

absl::StatusOr<ScatterReceivers> MakeScatterReceivers(const gl::Context& context, const ReceiverMap& receivers) {
  ScatterReceivers result;
  result.size = receivers.receivers.width;
  result.window = receivers.window;
  constexpr float kNobody = std::numeric_limits<float>::infinity();
  float least = kNobody;
  std::vector<float> w_or_nobody;
  w_or_nobody.reserve(receivers.light_z.size());
  result.w.reserve(receivers.light_z.size());
  for (const float z : receivers.light_z) {
    const float w = z > 0 ? 1 / z : 0;
    result.w.push_back(w);
    w_or_nobody.push_back(w > 0 ? w : kNobody);
    least = std::min(least, w_or_nobody.back());
  }
  result.least_w = least == kNobody ? 0 : least;
  const DepthPyramid pyramid = BuildDepthPyramid(w_or_nobody, result.size);
  result.base_side = pyramid.levels[0].side;
  ASSIGN_OR_RETURN(result.ranges, gl::Buffer::Create(context, pyramid.ranges));
  ASSIGN_OR_RETURN(result.w_on_gl, gl::Texture::Create2D(context, GL_R32F, result.size, result.size));
  RETURN_IF_ERROR(result.w_on_gl.WriteFloats(result.w.data(), result.w.size()));
  return result;
}

bool ScatterReceivers::LeavesMap(size_t index, const BinnedMap& map, const glm::dvec2& half_edges) const {
  const glm::dvec2 place(double(index % size) + 0.5, double(index / size) + 0.5);
  const glm::dvec2 slope = glm::dvec2(window) + place * ((window.z - window.x) / size) - map.point * double(w[index]);
  const double ahead = std::max(1 / map.z_near - w[index], 0.0);
  const glm::dvec2 reach = glm::abs(slope) + half_edges * ahead;
  return std::max(reach.x, reach.y) > map.side_slope;
}

absl::StatusOr<ScatterSums> Scatter(const DrawContext& draw, const BinnedMap& map, const glm::dvec2& half_edges,
                                    const ScatterReceivers& receivers, SsmBlend blend) {
  return Scatterer(draw, map, half_edges, receivers).Run(blend);
}

}  // namespace halfshade
