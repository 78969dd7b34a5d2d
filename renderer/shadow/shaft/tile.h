// Sixteen blocks of sixteen receivers, as arrays: what the lanes read.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/light/cpu_receivers.h"
#include "renderer/request.h"
#include "renderer/shadow/shaft/polygons.h"

namespace halfshade {

struct alignas(64) Tile {
  static constexpr int kBlocks = 16;
  static constexpr int kLanes = 16;
  static constexpr int kMost = kBlocks * kLanes;

  // Shaft space.
  float x[kMost], y[kMost], z[kMost];
  // Of the tangent plane: normal . p - offset are the metres of p above it. Without a horizon: zeros.
  float normal_x[kMost], normal_y[kMost], normal_z[kMost], offset[kMost];
  // Up to so many metres, and 4 ulps of an occluder's distance, plane and occluder cannot be told apart.
  float error_m[kMost];
  // Metres of the light's point (x, y) above the plane: up_x x + up_y y + up.
  float up_x[kMost], up_y[kMost], up[kMost];
  float shift_x[kMost], shift_y[kMost];  // of the samples, in [0,1) of their spacing and of a row
  uint32_t index[kMost];                 // into CpuReceivers
  // Bit per lane: it receives and the light, or part of it, shines on it. The others hold copies of one that does.
  uint32_t active[kBlocks];
  uint32_t cut[kBlocks];  // bit per lane: part of the light is below its plane
  uint32_t block_hash[kBlocks];
  bool shares_plane[kBlocks];     // all active lanes have one, to the bit
  bool shares_one_plane = false;  // of all blocks
  float size_m = 0;               // largest |x| + |y| + |z| of the active, of the light's frame
  bool is_loose = false;          // receivers without planes
};

// Leaves no others of the tile's blocks active than these, a bit each. False: none of their receivers is.
bool KeepBlocks(uint32_t blocks, Tile* tile);

// Takes from the tile the receivers that stand apart from others of it, as a silhouette does from the ground behind,
// into tiles of their own, kMostApart at most: the hull of both holds much that hides the light from neither.
void SplitTile(Tile* tile, std::vector<Tile>* apart);
inline constexpr size_t kMostApart = 3;

// Tiles of 16 x 16 pixels in blocks of 4 x 4, or runs of 256 points in blocks of 16.
class TileFiller {
 public:
  // `is_sparse`: of pixels the one of each block that SparseGrid::PixelOf names, as a picture of a sixteenth.
  TileFiller(const CpuReceivers& receivers, const AreaLight& light, const ShaftSpace& space, uint32_t seed,
             bool is_sparse = false);
  int count() const { return columns_ * rows_; }
  // False: no receiver of it is active, and nothing but index is filled in.
  bool Fill(int index, Tile* tile) const;

 private:
  // A receiver's plane in light space and in shaft space; neighbours share it.
  struct PlaneInLight {
    glm::vec4 plane{0};  // CpuReceivers::planes
    glm::dvec3 normal{0}, normal_in_shaft{0};
    double middle = 0;  // of the light, above the plane
    glm::dvec2 up{0};   // of the light's edges
  };
  PlaneInLight ToLight(const glm::vec4& plane) const;
  bool FillLane(int lane, size_t receiver, const glm::dvec2& ndc, PlaneInLight* last, Tile* tile) const;

  const CpuReceivers& receivers_;
  ShaftSpace space_;
  uint32_t seed_;
  int width_, height_;  // of what tiles are cut from
  bool is_sparse_;
  int tile_width_ = 16, tile_height_ = 16, block_width_ = 4;
  int columns_ = 0, rows_ = 0;
  glm::dmat3 light_from_world_;
  glm::dmat3 ray_from_ndc_;  // light frame
  glm::dvec3 eye_ls_;
  glm::dvec2 edges_;
};

}  // namespace halfshade
