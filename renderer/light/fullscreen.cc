#include "renderer/light/fullscreen.h"

#include <glad/gl.h>

#include <algorithm>

#include "renderer/status.h"

namespace halfshade {

absl::Status DrawFullscreen(const DrawContext& draw, int width, int height, double nanoseconds_per_pixel) {
  const GladGLContext& gl = draw.context->gl();
  const double row_ms = std::max(1e-9, nanoseconds_per_pixel * 1e-6 * width);
  const int rows_per_band = int(std::clamp(draw.pacer->MostMs() / row_ms, 1.0, double(height)));
  const gl::VertexArray no_attributes = gl::VertexArray::Create(*draw.context);
  gl.BindVertexArray(no_attributes.id());
  gl.Enable(GL_SCISSOR_TEST);
  absl::Status status;
  for (int row = 0; row < height && status.ok(); row += rows_per_band) {
    const int rows = std::min(rows_per_band, height - row);
    status = draw.pacer->Charge(row_ms * rows);
    if (!status.ok()) break;
    gl.Scissor(0, row, width, rows);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
  }
  gl.Disable(GL_SCISSOR_TEST);
  return status;
}

}  // namespace halfshade
