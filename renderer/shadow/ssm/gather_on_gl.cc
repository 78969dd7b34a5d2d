#include "renderer/shadow/ssm/gather_on_gl.h"

#include <glad/gl.h>

#include "renderer/gl/framebuffer.h"
#include "renderer/light/fullscreen.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// llvmpipe, two cores, measured high; a GPU is far below.
constexpr double kNanosecondsPerPixel = 2000;
constexpr int kDepthsUnit[] = {kPlanesUnit + 1, kPlanesUnit + 2};
constexpr int kHiddenPointUnit = kPlanesUnit + 3;
constexpr GLuint kSumsBinding[] = {2, 3};

}  // namespace

uint64_t BinnedMapOnGl::SizeBytes() const {
  return depths.SizeBytes() + map.tables.SizeBytes() + (map.all_sides != nullptr ? map.all_sides->SizeBytes() : 0);
}

absl::StatusOr<BinnedMapOnGl> UploadBinnedMap(const gl::Context& context, BinnedMap map) {
  BinnedMapOnGl on_gl;
  ASSIGN_OR_RETURN(on_gl.depths, gl::Texture::Create2D(context, GL_R32F, map.map_size, map.map_size));
  RETURN_IF_ERROR(on_gl.depths.WriteFloats(map.depths.data(), size_t(map.map_size) * map.map_size));
  ASSIGN_OR_RETURN(on_gl.sums, gl::Buffer::Create(context, map.tables.sums.get(), map.tables.SizeBytes()));
  map.depths = {};
  map.tables.sums = nullptr;
  on_gl.map = std::move(map);
  return on_gl;
}

absl::Status GatherOnGl(const DrawContext& draw, std::span<const BinnedMapOnGl> layers, const glm::dvec2& half_edges,
                        const AreaLight& light, const Receivers& receivers, const gl::Texture& sums) {
  const GladGLContext& gl = draw.context->gl();
  const BinnedMap& map = layers[0].map;
  gl::Texture hidden_point;
  if (map.all_sides != nullptr) {
    ASSIGN_OR_RETURN(hidden_point, map.all_sides->CountHidden(draw, receivers));
  }
  ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::Create(*draw.context, {&sums}));
  ASSIGN_OR_RETURN(gl::Program * program, draw.programs->Get("common/fullscreen.vert", "ssm/gather.frag"));
  framebuffer.Bind();
  gl.Viewport(0, 0, receivers.width, receivers.height);
  gl.Disable(GL_DEPTH_TEST);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ONE);
  program->Use();
  SetReceivers(*program, receivers, light);
  std::vector<glm::vec4> tables;
  for (size_t k = 0; k < layers.size(); ++k) {
    const DepthTables& t = layers[k].map.tables;
    layers[k].depths.Bind(kDepthsUnit[k]);
    program->Set("depths[" + std::to_string(k) + "]", kDepthsUnit[k]);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kSumsBinding[k], layers[k].sums.id());
    tables.emplace_back(t.first_depth, t.slab_depth, t.slabs_per_depth, t.nearest_depth);
  }
  program->Set("tables", tables);
  program->Set("layer_count", int(layers.size()));
  program->Set("table_size", map.tables.size);
  program->Set("slabs", map.tables.slabs);
  program->Set("entry", map.tables.entry);
  program->Set("texels_per_patch", map.texels_per_patch);
  program->Set("map_size", map.map_size);
  program->Set("first_center", glm::vec2(map.first_center));
  program->Set("slope_per_texel", glm::vec2(map.slope_per_texel));
  program->Set("z_near", float(map.z_near));
  program->Set("light_point", glm::vec2(map.point));
  program->Set("half_edges", glm::vec2(half_edges));
  program->Set("side_slope", float(map.side_slope));
  if (hidden_point) hidden_point.Bind(kHiddenPointUnit);
  program->Set("hidden_point", hidden_point ? kHiddenPointUnit : kDepthsUnit[0]);
  const absl::Status status =
      DrawFullscreen(draw, receivers.width, receivers.height, kNanosecondsPerPixel * double(layers.size()));
  gl.Disable(GL_BLEND);
  RETURN_IF_ERROR(status);
  return draw.context->Check("ssm/gather");
}

}  // namespace halfshade
