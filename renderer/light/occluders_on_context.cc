#include "renderer/light/occluders_on_context.h"

#include <glad/gl.h>

#include <algorithm>

#include "renderer/status.h"

namespace halfshade {
namespace {

// llvmpipe on two cores: 51 k triangles at 512^2 take 10 ms of both, vertices and setup the most of it.
constexpr double kMillisecondsPerTriangle = 2e-4;
constexpr double kMillisecondsPerTexel = 1e-6;
constexpr uint64_t kTrianglesPerDraw = 65536;

}  // namespace

absl::StatusOr<std::unique_ptr<OccludersOnContext>> OccludersOnContext::Create(const DrawContext& draw,
                                                                               const LightSpaceOccluders& occluders) {
  auto result = std::unique_ptr<OccludersOnContext>(new OccludersOnContext);
  result->hull_ = occluders.hull;
  result->index_count_ = occluders.indices.size();
  result->size_bytes_ = occluders.SizeBytes();
  if (occluders.indices.empty()) return result;
  const gl::Context& context = *draw.context;
  ASSIGN_OR_RETURN(result->positions_, gl::Buffer::Create(context, occluders.positions));
  ASSIGN_OR_RETURN(result->indices_, gl::Buffer::Create(context, occluders.indices));
  result->vertex_array_ = gl::VertexArray::Create(context);
  result->vertex_array_.SetFloats(0, 3, result->positions_.id());
  context.gl().VertexArrayElementBuffer(result->vertex_array_.id(), result->indices_.id());
  RETURN_IF_ERROR(context.Check("light/occluders"));
  return result;
}

absl::Status OccludersOnContext::DrawDepth(const DrawContext& draw, int side, const glm::dvec2& point,
                                           const glm::dvec4& window, int size) const {
  if (index_count_ == 0) return absl::OkStatus();
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("light/depth.vert", "light/depth.frag"));
  program->Use();
  const glm::dmat3 map_from_light = MapFromLight(side);
  const glm::dvec2 scale = glm::dvec2(window.z, window.w) * (2.0 / size);
  program->Set("map_from_light", glm::mat3(map_from_light));
  program->Set("sample_position", glm::vec3(map_from_light * glm::dvec3(point, 0)));
  program->Set("ndc_from_slope", glm::vec4(scale, -glm::dvec2(window) * scale - 1.0));
  program->Set("z_near", float(hull_.z_near()));
  const GladGLContext& gl = draw.context->gl();
  gl.BindVertexArray(vertex_array_.id());
  RETURN_IF_ERROR(draw.pacer->Charge(kMillisecondsPerTexel * size * size));
  for (uint64_t first = 0; first < index_count_; first += 3 * kTrianglesPerDraw) {
    const uint64_t count = std::min(3 * kTrianglesPerDraw, index_count_ - first);
    RETURN_IF_ERROR(draw.pacer->Charge(kMillisecondsPerTriangle * double(count / 3)));
    gl.DrawElements(GL_TRIANGLES, GLsizei(count), GL_UNSIGNED_INT,
                    reinterpret_cast<const void*>(first * sizeof(uint32_t)));
  }
  return absl::OkStatus();
}

}  // namespace halfshade
