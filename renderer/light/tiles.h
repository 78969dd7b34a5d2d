// Parts of the picture as lists of tiles. llvmpipe does all work behind `if`, `return` and `discard`; what is not in a
// list it does not do.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/program.h"

namespace halfshade {

inline constexpr int kTilePixels = 16;

// Column and row of tiles.
using TileList = std::vector<glm::ivec2>;

// The tiles of a picture [height][width] with a pixel that is_wanted[row * width + column]; all for an empty vector.
TileList ListTiles(int width, int height, const std::vector<bool>& is_wanted);

// Draws the tiles over the bound framebuffer of width x height with `program` (common/tiles.vert) in use, in
// submissions that the pacer allows. Sets the viewport. A pixel of a tile beyond the picture is cut off.
absl::Status DrawTiles(const DrawContext& draw, gl::Program& program, int width, int height, const TileList& tiles,
                       double nanoseconds_per_pixel);

}  // namespace halfshade
