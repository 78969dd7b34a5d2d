// Hidden fractions between pixels that were evaluated: one of each block of 4 x 4. Pure; no GL.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/light/cpu_receivers.h"

namespace halfshade {

// One pixel of each block.
class SparseGrid {
 public:
  static constexpr int kBlock = 4;  // pixels a side

  // Takes from images of the whole size what was evaluated at the pixels that PixelOf names; where nothing was,
  // errors < 0.
  SparseGrid(const CpuReceivers& receivers, const std::vector<float>& hidden, const std::vector<float>& errors);

  // The evaluated pixel of block `column` or `row` in an image of `size` pixels.
  static int PixelOf(int block, int size) { return block * kBlock + 1 < size ? block * kBlock + 1 : size - 1; }

  int columns() const { return columns_; }
  int rows() const { return rows_; }

  // Writes the block's pixels, if it and the blocks around are of one smooth surface, evaluated, and their fractions
  // bend by no more than `most_bend` (of second differences) over it: linear interpolation is off by an eighth of that.
  bool Interpolate(int column, int row, float most_bend, std::vector<float>* hidden, std::vector<float>* errors) const;

 private:
  struct Sample {
    glm::dvec3 from_eye{0};
    glm::vec4 plane{0};
    float hidden = 0, error = -1;
  };
  const Sample& At(int column, int row) const { return samples_[size_t(row) * columns_ + column]; }
  // Metres that a block spans at the sample.
  double BlockSize(const Sample& sample) const;

  const CpuReceivers& receivers_;
  int columns_, rows_;
  std::vector<Sample> samples_;
};

}  // namespace halfshade
