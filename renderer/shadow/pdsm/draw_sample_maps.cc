#include "renderer/shadow/pdsm/draw_sample_maps.h"

#include <glad/gl.h>

#include <algorithm>

#include "renderer/gl/framebuffer.h"
#include "renderer/gl/texture.h"
#include "renderer/status.h"

namespace halfshade::pdsm {
namespace {

Window FrontWindow(const OccluderHull& hull, const glm::dvec2& point) {
  const Window window = hull.FrontWindow(point);
  return window.IsEmpty() ? Window{0, 0, 0, 0} : window;
}

absl::Status DrawMap(const DrawContext& draw, const OccludersOnContext& occluders, const Grid& grid,
                     const gl::Framebuffer& framebuffer, const SampleMap& map) {
  const GladGLContext& gl = draw.context->gl();
  framebuffer.Bind();
  gl.Viewport(0, 0, grid.map_size, grid.map_size);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_GREATER);
  gl.DepthMask(GL_TRUE);
  gl.Disable(GL_CULL_FACE);
  gl.Disable(GL_BLEND);
  gl.Enable(GL_DEPTH_CLAMP);  // what is nearer than z_near occludes too, as if it stood there
  const float empty = 0;
  gl.ClearBufferfv(GL_DEPTH, 0, &empty);
  const absl::Status status =
      occluders.DrawDepth(draw, 0, map.point, glm::dvec4(map.corner, 1.0 / grid.MapTexel()), grid.map_size);
  gl.Disable(GL_DEPTH_CLAMP);
  return status;
}

}  // namespace

Grid GridOf(const OccluderHull& hull, const glm::dvec2& half_edges, const std::vector<glm::dvec2>& points, int map_size,
            int pdsm_size) {
  GridNeeds needs;
  needs.half_edges = half_edges;
  needs.z_near = hull.z_near();
  needs.map_size = map_size;
  needs.pdsm_size = pdsm_size;
  // An occluder at depth w seen from s hides what lies between its own ray (from the centre) and u - s w, from s's
  // window: the windows of the light's corners, whose hull holds the centre's, bound both.
  needs.rays = FrontWindow(hull, half_edges);
  for (const glm::dvec2 corner : {glm::dvec2(-1, -1), glm::dvec2(-1, 1), glm::dvec2(1, -1)}) {
    const Window window = FrontWindow(hull, corner * half_edges);
    needs.rays = {std::min(needs.rays.u0, window.u0), std::min(needs.rays.v0, window.v0),
                  std::max(needs.rays.u1, window.u1), std::max(needs.rays.v1, window.v1)};
  }
  for (const glm::dvec2& point : points) needs.maps.push_back(FrontWindow(hull, point));
  return MakeGrid(needs);
}

absl::Status DrawSampleMaps(const DrawContext& draw, const OccludersOnContext& occluders, const Grid& grid,
                            const std::vector<glm::dvec2>& points,
                            const std::function<absl::Status(const SampleMap&)>& take) {
  ASSIGN_OR_RETURN(const gl::Texture texture,
                   gl::Texture::Create2DArray(*draw.context, GL_DEPTH_COMPONENT32F, grid.map_size, grid.map_size, 1));
  ASSIGN_OR_RETURN(const gl::Framebuffer framebuffer, gl::Framebuffer::CreateDepthLayer(*draw.context, texture, 0));
  const auto depth_scale = float(grid.z_near / occluders.hull().z_near());
  SampleMap map;
  map.depths.resize(size_t(grid.map_size) * grid.map_size);
  for (size_t i = 0; i < points.size(); ++i) {
    map.point = points[i];
    map.corner = MapCorner(grid, FrontWindow(occluders.hull(), points[i]), i);
    RETURN_IF_ERROR(DrawMap(draw, occluders, grid, framebuffer, map));
    RETURN_IF_ERROR(draw.pacer->Finish());
    RETURN_IF_ERROR(texture.ReadFloats(map.depths.data(), map.depths.size()));
    if (depth_scale != 1) {
      for (float& depth : map.depths) depth = std::min(1.0f, depth * depth_scale);
    }
    RETURN_IF_ERROR(take(map));
  }
  return draw.context->Check("pdsm/maps");
}

}  // namespace halfshade::pdsm
