// A tile of receivers in the frame of a light, as arrays: what the CPU's loops over maps read.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "renderer/light/cpu_receivers.h"
#include "renderer/request.h"

namespace halfshade {

// Those that receive and stand in front of the light. Slopes and w = 1/z as seen from the light's centre, in double: a
// map has a thousand texels, and a float only some ten thousand places between two of them.
struct ReceiverTile {
  static constexpr int kSide = 8;  // pixels
  static constexpr int kMost = kSide * kSide;

  int count = 0;
  uint32_t index[kMost];  // into CpuReceivers
  double u[kMost], v[kMost], w[kMost];
  // Of the tangent plane: unit normal, and how high the light's centre stands above it. Without a horizon: 0, huge.
  float normal_x[kMost], normal_y[kMost], normal_z[kMost], height[kMost];
  float error[kMost];  // metres by which the plane may be off: 4 ulps of the distances it was made from

  // Of all of them.
  glm::dvec2 slope_low{0}, slope_high{0};
  double w_low = 0, w_high = 0;
  bool shares_plane = false;      // one plane, to the bit
  bool sees_whole_light = false;  // all of it above every plane
};

// Fills tiles of pixels (or runs of points) from receivers in memory.
class ReceiverTiles {
 public:
  ReceiverTiles(const CpuReceivers& receivers, const AreaLight& light);
  int columns() const { return columns_; }
  int count() const { return columns_ * rows_; }
  void Fill(int tile, ReceiverTile* result) const;

 private:
  const CpuReceivers& receivers_;
  int columns_ = 0, rows_ = 0;
  glm::dmat3 light_from_world_;
  glm::dmat3 ray_from_ndc_;  // light frame
  glm::dvec3 eye_ls_;
  glm::vec2 half_edges_;
};

}  // namespace halfshade
