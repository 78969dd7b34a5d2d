#include "renderer/light/tiles.h"

#include <glad/gl.h>

#include <algorithm>

#include "renderer/gl/handles.h"
#include "renderer/status.h"

namespace halfshade {

TileList ListTiles(int width, int height, const std::vector<bool>& is_wanted) {
  TileList tiles;
  for (int top = 0; top < height; top += kTilePixels) {
    for (int left = 0; left < width; left += kTilePixels) {
      bool is_listed = is_wanted.empty();
      for (int y = top; y < std::min(top + kTilePixels, height) && !is_listed; ++y) {
        for (int x = left; x < std::min(left + kTilePixels, width) && !is_listed; ++x) {
          is_listed = is_wanted[size_t(y) * width + x];
        }
      }
      if (is_listed) tiles.emplace_back(left / kTilePixels, top / kTilePixels);
    }
  }
  return tiles;
}

absl::Status DrawTiles(const DrawContext& draw, gl::Program& program, int width, int height, const TileList& tiles,
                       double nanoseconds_per_pixel) {
  if (tiles.empty()) return absl::OkStatus();
  const GladGLContext& gl = draw.context->gl();
  std::vector<glm::vec2> centers;
  for (const glm::ivec2& tile : tiles) centers.emplace_back((glm::vec2(tile) + 0.5f) * float(kTilePixels));
  ASSIGN_OR_RETURN(const gl::Buffer buffer, gl::Buffer::Create(*draw.context, centers));
  const gl::VertexArray vertex_array = gl::VertexArray::Create(*draw.context);
  vertex_array.SetFloats(0, 2, buffer.id());
  gl.BindVertexArray(vertex_array.id());
  // A point whose centre is outside the viewport would not be drawn: it holds whole tiles.
  const glm::ivec2 viewport = (glm::ivec2(width, height) + kTilePixels - 1) / kTilePixels * kTilePixels;
  gl.Viewport(0, 0, viewport.x, viewport.y);
  program.Set("ndc_from_viewport", glm::vec2(2.0) / glm::vec2(viewport));
  program.Set("tile_pixels", float(kTilePixels));
  gl.Enable(GL_PROGRAM_POINT_SIZE);
  const double tile_ms = nanoseconds_per_pixel * 1e-6 * kTilePixels * kTilePixels;
  const size_t at_once = size_t(std::clamp(draw.pacer->MostMs() / tile_ms, 1.0, 1e6));
  absl::Status status;
  for (size_t first = 0; first < tiles.size() && status.ok(); first += at_once) {
    const size_t count = std::min(at_once, tiles.size() - first);
    status = draw.pacer->Charge(tile_ms * double(count));
    if (status.ok()) gl.DrawArrays(GL_POINTS, GLint(first), GLsizei(count));
  }
  gl.Disable(GL_PROGRAM_POINT_SIZE);
  return status;
}

}  // namespace halfshade
