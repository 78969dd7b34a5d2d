// A plain float image. Row 0 on top.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace halfshade {

// [height][width][channels] float32.
class Image {
 public:
  Image() = default;
  Image(int width, int height, int channels)
      : width_(width), height_(height), channels_(channels), data_(size_t(width) * height * channels) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  float* data() { return data_.data(); }
  const float* data() const { return data_.data(); }
  size_t size() const { return data_.size(); }
  float& at(int x, int y, int c) { return data_[Index(x, y, c)]; }
  float at(int x, int y, int c) const { return data_[Index(x, y, c)]; }

 private:
  size_t Index(int x, int y, int c) const {
    assert(x >= 0 && x < width_ && y >= 0 && y < height_ && c >= 0 && c < channels_);
    return (size_t(y) * width_ + x) * channels_ + c;
  }
  int width_ = 0;
  int height_ = 0;
  int channels_ = 0;
  std::vector<float> data_;
};

}  // namespace halfshade
