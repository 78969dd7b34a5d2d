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
constexpr int kMaskUnit = 0;

}  // namespace

absl::StatusOr<std::unique_ptr<OccludersOnContext>> OccludersOnContext::Create(const DrawContext& draw,
                                                                               const FlatScene& scene,
                                                                               const SceneOnContext& on_context,
                                                                               const LightSpaceOccluders& occluders) {
  auto result = std::unique_ptr<OccludersOnContext>(new OccludersOnContext);
  result->hull_ = occluders.hull;
  result->index_count_ = occluders.indices.size();
  result->opaque_index_count_ = occluders.masked.empty() ? result->index_count_ : occluders.masked[0].first_index;
  result->size_bytes_ = occluders.SizeBytes();
  if (occluders.indices.empty()) return result;
  const gl::Context& context = *draw.context;
  const GladGLContext& gl = context.gl();
  ASSIGN_OR_RETURN(result->positions_, gl::Buffer::Create(context, occluders.positions));
  ASSIGN_OR_RETURN(result->indices_, gl::Buffer::Create(context, occluders.indices));
  result->vertex_array_ = gl::VertexArray::Create(context);
  result->vertex_array_.SetFloats(0, 3, result->positions_.id());
  gl.VertexArrayElementBuffer(result->vertex_array_.id(), result->indices_.id());
  if (!occluders.masked.empty()) {
    // The same positions from the first masked one on, beside their mask vertices.
    ASSIGN_OR_RETURN(result->mask_vertices_, gl::Buffer::Create(context, occluders.mask_vertices));
    result->first_masked_vertex_ = occluders.first_masked_vertex;
    result->masked_vertex_array_ = gl::VertexArray::Create(context);
    const GLuint array = result->masked_vertex_array_.id();
    result->masked_vertex_array_.SetFloats(0, 3, result->positions_.id());
    gl.VertexArrayVertexBuffer(array, 0, result->positions_.id(),
                               GLintptr(occluders.first_masked_vertex * sizeof(glm::vec3)), sizeof(glm::vec3));
    result->masked_vertex_array_.SetFloats(1, 3, result->mask_vertices_.id());
    if (!occluders.blend_places.empty()) {
      ASSIGN_OR_RETURN(result->blend_places_, gl::Buffer::Create(context, occluders.blend_places));
      result->masked_vertex_array_.SetFloats(2, 3, result->blend_places_.id());
    }
    gl.VertexArrayElementBuffer(array, result->indices_.id());
    for (const MaskedOccluders& range : occluders.masked) {
      const Material& material = scene.materials[range.material];
      result->masked_.push_back({range, on_context.textures(range.material).mask, material.alpha_cutoff,
                                 material.alpha_mode == AlphaMode::kBlend});
    }
  }
  RETURN_IF_ERROR(context.Check("light/occluders"));
  return result;
}

absl::Status OccludersOnContext::DrawRange(const DrawContext& draw, uint64_t first_index, uint64_t index_count,
                                           int base_vertex) const {
  for (uint64_t done = 0; done < index_count; done += 3 * kTrianglesPerDraw) {
    const uint64_t count = std::min(3 * kTrianglesPerDraw, index_count - done);
    const uint64_t triangles = count / 3;
    RETURN_IF_ERROR(draw.pacer->Charge(kMillisecondsPerTriangle * double(triangles)));
    draw.context->gl().DrawElementsBaseVertex(GL_TRIANGLES, GLsizei(count), GL_UNSIGNED_INT,
                                              reinterpret_cast<const void*>((first_index + done) * sizeof(uint32_t)),
                                              base_vertex);
  }
  return absl::OkStatus();
}

absl::Status OccludersOnContext::DrawDepth(const DrawContext& draw, int side, const glm::dvec2& point,
                                           const glm::dvec4& window, int size) const {
  if (index_count_ == 0) return absl::OkStatus();
  const glm::dmat3 map_from_light = MapFromLight(side);
  const glm::dvec2 scale = glm::dvec2(window.z, window.w) * (2.0 / size);
  const auto use = [&](const std::vector<std::string>& defines) -> absl::StatusOr<gl::Program*> {
    ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("light/depth.vert", "light/depth.frag", defines));
    program->Use();
    program->Set("map_from_light", glm::mat3(map_from_light));
    program->Set("sample_position", glm::vec3(map_from_light * glm::dvec3(point, 0)));
    program->Set("ndc_from_slope", glm::vec4(scale, -glm::dvec2(window) * scale - 1.0));
    program->Set("z_near", float(hull_.z_near()));
    return program;
  };
  const GladGLContext& gl = draw.context->gl();
  RETURN_IF_ERROR(draw.pacer->Charge(kMillisecondsPerTexel * size * size));
  if (opaque_index_count_ > 0) {
    RETURN_IF_ERROR(use({}).status());
    gl.BindVertexArray(vertex_array_.id());
    RETURN_IF_ERROR(DrawRange(draw, 0, opaque_index_count_, 0));
  }
  if (masked_.empty()) return absl::OkStatus();
  const std::vector<std::string> kMask = {"HAS_MASK"}, kBlend = {"HAS_MASK", "HAS_BLEND"};
  gl.BindVertexArray(masked_vertex_array_.id());
  for (const Masked& masked : masked_) {
    ASSIGN_OR_RETURN(gl::Program * program, use(masked.is_blend ? kBlend : kMask));
    program->Set("mask", kMaskUnit);
    program->Set("has_mask_texture", int(bool(masked.mask)));
    if (!masked.is_blend) program->Set("alpha_cutoff", masked.alpha_cutoff);
    if (masked.mask) masked.mask.Bind(kMaskUnit);
    RETURN_IF_ERROR(DrawRange(draw, masked.range.first_index, masked.range.index_count, -int(first_masked_vertex_)));
  }
  gl.BindSampler(kMaskUnit, 0);
  return absl::OkStatus();
}

}  // namespace halfshade
