#include "renderer/shadow/shaft/sparse.h"

#include <algorithm>
#include <cmath>

namespace halfshade {
namespace {

// Of the normals of one smooth surface: 18 degrees.
constexpr float kLeastCosine = 0.95f;

// Whether the point stands on the plane, `normal` about along its own.
bool IsOn(const glm::vec4& plane, const glm::dvec3& from_eye, const glm::vec4& other, double tolerance_m) {
  if (plane == other) return true;
  return glm::dot(glm::vec3(plane), glm::vec3(other)) >= kLeastCosine &&
         std::abs(glm::dot(glm::dvec3(plane), from_eye) - plane.w) <= tolerance_m;
}

}  // namespace

SparseGrid::SparseGrid(const CpuReceivers& receivers, const std::vector<float>& hidden,
                       const std::vector<float>& errors)
    : receivers_(receivers),
      columns_((receivers.width + kBlock - 1) / kBlock),
      rows_((receivers.height + kBlock - 1) / kBlock),
      samples_(size_t(columns_) * rows_) {
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const size_t pixel = size_t(PixelOf(row, receivers.height)) * receivers.width + PixelOf(column, receivers.width);
      if (errors[pixel] < 0) continue;
      const glm::dvec3 from_eye = receivers.At(pixel).position_ws - receivers.camera.eye_ws;
      samples_[size_t(row) * columns_ + column] = {from_eye, receivers.planes[pixel], hidden[pixel], errors[pixel]};
    }
  }
}

double SparseGrid::BlockSize(const Sample& sample) const {
  const Camera& camera = receivers_.camera;
  const double height_m =
      camera.is_orthographic ? camera.ortho_height_m : 2 * camera.tan_half_fovy * glm::length(sample.from_eye);
  return kBlock * height_m / receivers_.height;
}

bool SparseGrid::Interpolate(int column, int row, float most_bend, std::vector<float>* hidden,
                             std::vector<float>* errors) const {
  const Sample& middle = At(column, row);
  if (middle.error < 0) return false;
  const double tolerance_m = BlockSize(middle);
  float around[3][3], mean_error = 0;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      const Sample& sample = At(std::clamp(column + i - 1, 0, columns_ - 1), std::clamp(row + j - 1, 0, rows_ - 1));
      if (sample.error < 0 || !IsOn(middle.plane, sample.from_eye, sample.plane, tolerance_m)) return false;
      around[j][i] = sample.hidden;
      mean_error += sample.error / 9;
    }
  }
  float bend = 0;
  for (int k = 0; k < 3; ++k) {
    bend = std::max({bend, std::abs(around[k][0] + around[k][2] - 2 * around[k][1]),
                     std::abs(around[0][k] + around[2][k] - 2 * around[1][k])});
  }
  if (bend > most_bend) return false;
  const int left = column * kBlock, top = row * kBlock;
  const int right = std::min(left + kBlock, receivers_.width), bottom = std::min(top + kBlock, receivers_.height);
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const size_t pixel = size_t(y) * receivers_.width + x;
      if (!receivers_.IsReceiving(pixel) || !IsOn(receivers_.planes[pixel], middle.from_eye, middle.plane, tolerance_m))
        return false;
    }
  }
  // Of the samples, which their mean halves or so, and of what bends more than they explain.
  const float error = 0.75f * mean_error + std::max(0.0f, bend - 4 * mean_error) / 8;
  for (int y = top; y < bottom; ++y) {
    const float t = float(y - PixelOf(row, receivers_.height)) / kBlock;
    for (int x = left; x < right; ++x) {
      const float s = float(x - PixelOf(column, receivers_.width)) / kBlock;
      const int i = s < 0 ? 0 : 1, j = t < 0 ? 0 : 1;
      const float a = s < 0 ? s + 1 : s, b = t < 0 ? t + 1 : t;
      const float upper = around[j][i] * (1 - a) + around[j][i + 1] * a;
      const float lower = around[j + 1][i] * (1 - a) + around[j + 1][i + 1] * a;
      const size_t pixel = size_t(y) * receivers_.width + x;
      (*hidden)[pixel] = upper * (1 - b) + lower * b;
      (*errors)[pixel] = error;
    }
  }
  return true;
}

}  // namespace halfshade
