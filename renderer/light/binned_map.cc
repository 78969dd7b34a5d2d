#include "renderer/light/binned_map.h"

#include <glad/gl.h>

#include <algorithm>
#include <limits>

#include "renderer/gl/framebuffer.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// Reads the depths of the surfaces that are furthest, as a map of this view holds them.
absl::Status ReadFurthest(const DrawContext& draw, const OccludersOnContext& occluders, const BinnedMap& map,
                          float* depths, size_t count) {
  const GladGLContext& gl = draw.context->gl();
  ASSIGN_OR_RETURN(const gl::Texture texture,
                   gl::Texture::Create2DArray(*draw.context, GL_DEPTH_COMPONENT32F, map.map_size, map.map_size, 1));
  ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::CreateDepthLayer(*draw.context, texture, 0));
  framebuffer.Bind();
  gl.Viewport(0, 0, map.map_size, map.map_size);
  const float nearer_than_all = 1;
  gl.ClearBufferfv(GL_DEPTH, 0, &nearer_than_all);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_LESS);
  gl.DepthMask(GL_TRUE);
  gl.Disable(GL_CULL_FACE);
  gl.Disable(GL_BLEND);
  gl.Enable(GL_DEPTH_CLAMP);
  const glm::dvec2 corner = map.first_center - 0.5 * map.slope_per_texel;
  const absl::Status status =
      occluders.DrawDepth(draw, 0, map.point, glm::dvec4(corner, 1.0 / map.slope_per_texel), map.map_size);
  gl.Disable(GL_DEPTH_CLAMP);
  RETURN_IF_ERROR(status);
  RETURN_IF_ERROR(texture.ReadFloats(depths, count));
  std::replace(depths, depths + count, nearer_than_all, 0.0f);
  return draw.context->Check("light/furthest");
}

}  // namespace

absl::StatusOr<BinnedMap> DrawBinnedMap(const DrawContext& draw, std::shared_ptr<const OccludersOnContext> occluders,
                                        const AreaLight& light, const glm::dvec2& point,
                                        const BinnedMapOptions& options) {
  BinnedMap map;
  map.point = point;
  map.texels_per_patch = options.texels_per_patch;
  map.map_size = options.size * options.texels_per_patch;
  ASSIGN_OR_RETURN(std::unique_ptr<SampleMaps> maps, SampleMaps::Create(draw, occluders, light, {point}, map.map_size,
                                                                        std::numeric_limits<uint64_t>::max()));
  const SampleMaps::FrontMap front = maps->front_map();
  map.first_center = front.first_center;
  map.slope_per_texel = front.slope_per_texel;
  map.z_near = front.z_near;
  map.side_slope = front.side_slope;
  const size_t texels = size_t(map.map_size) * map.map_size;
  map.depths.resize(texels + BinnedMap::kPadding);
  if (options.layer == OccluderLayer::kNearest) {
    RETURN_IF_ERROR(front.maps->ReadFloats(map.depths.data(), texels));
  } else {
    RETURN_IF_ERROR(ReadFurthest(draw, *occluders, map, map.depths.data(), texels));
  }
  if (options.slabs > 0) {
    ASSIGN_OR_RETURN(map.tables, BuildDepthTables(map.depths.data(), options.size, options.texels_per_patch,
                                                  options.slabs, [&draw] { return draw.pacer->Finish(); }));
  }
  if (map.side_slope > 0) map.all_sides = std::move(maps);
  return map;
}

}  // namespace halfshade
