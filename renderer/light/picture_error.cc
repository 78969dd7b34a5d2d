#include "renderer/light/picture_error.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/report.h"

namespace halfshade {
namespace {

constexpr int kTile = 16;
constexpr size_t kFewest = 16;  // differences of a tile; of fewer a median says nothing
constexpr float kSameNormal = 0.95f, kSameOffset = 0.02f;

// Second differences of three in a row, and the cross difference of four.
struct Difference {
  struct Term {
    int dx, dy;
    float weight;
  };
  std::array<Term, 4> terms;
  double deviation;  // of the sum, in those of a term
};
constexpr Difference kDifferences[] = {
    {{{{0, 0, -2}, {-1, 0, 1}, {1, 0, 1}, {0, 0, 0}}}, 2.449},
    {{{{0, 0, -2}, {0, -1, 1}, {0, 1, 1}, {0, 0, 0}}}, 2.449},
    {{{{0, 0, -2}, {-1, -1, 1}, {1, 1, 1}, {0, 0, 0}}}, 2.449},
    {{{{0, 0, -2}, {-1, 1, 1}, {1, -1, 1}, {0, 0, 0}}}, 2.449},
    {{{{0, 0, 1}, {1, 0, -1}, {0, 1, -1}, {1, 1, 1}}}, 2.0},
};
// Errors that are spread evenly have a mean size of sqrt(3)/2 of their deviation; a sum of three or four is nearly
// normal, of a median size of .6745 of its own.
constexpr double kErrorOfMedian = 0.866 / 0.6745;

bool IsSameSurface(const glm::vec4& a, const glm::vec4& b) {
  return glm::dot(glm::vec3(a), glm::vec3(b)) > kSameNormal &&
         std::abs(a.w - b.w) <= kSameOffset * (std::abs(a.w) + std::abs(b.w));
}

class Picture {
 public:
  Picture(const Image& visibility_and_share, const std::vector<float>& errors, const CpuReceivers* pixels)
      : image_(visibility_and_share), errors_(errors), pixels_(pixels) {}

  void AddTile(int left, int top, PictureError* total) {
    const int right = std::min(left + kTile, image_.width()), bottom = std::min(top + kTile, image_.height());
    double told = 0;
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        if (!IsShadowed(x, y)) continue;
        ++total->pixels;
        told += ErrorAt(x, y);
      }
    }
    double least = told;
    for (const Difference& difference : kDifferences) {
      if (pixels_ == nullptr || told == 0) break;
      double told_here = 0;
      sizes_.clear();
      for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
          const double size = SizeOf(difference, x, y);
          if (size < 0) continue;
          sizes_.push_back(size);
          told_here += ErrorAt(x, y);
        }
      }
      if (sizes_.size() < kFewest) continue;
      const auto middle = sizes_.begin() + std::ptrdiff_t(sizes_.size() / 2);
      std::nth_element(sizes_.begin(), middle, sizes_.end());
      // What stands in no difference keeps its word.
      const double seen = kErrorOfMedian / difference.deviation * *middle * double(sizes_.size());
      least = std::min(least, told - told_here + seen);
    }
    total->sum += least;
  }

 private:
  size_t Index(int x, int y) const { return size_t(y) * size_t(image_.width()) + size_t(x); }
  bool IsShadowed(int x, int y) const { return image_.at(x, y, 1) > 0 && image_.at(x, y, 0) < 1 - kPenumbraMargin; }
  bool IsPenumbra(int x, int y) const { return IsShadowed(x, y) && image_.at(x, y, 0) > kPenumbraMargin; }
  double ErrorAt(int x, int y) const { return double(image_.at(x, y, 1)) * errors_[Index(x, y)]; }

  // |difference|; below 0 where it is not of one smooth surface in penumbra.
  double SizeOf(const Difference& difference, int x, int y) const {
    if (!IsPenumbra(x, y)) return -1;
    double sum = 0;
    for (const auto& [dx, dy, weight] : difference.terms) {
      const int i = x + dx, k = y + dy;
      if (i < 0 || k < 0 || i >= image_.width() || k >= image_.height()) return -1;
      if (!IsPenumbra(i, k) || !IsSameSurface(pixels_->planes[Index(x, y)], pixels_->planes[Index(i, k)])) return -1;
      sum += double(weight) * double(image_.at(i, k, 0));
    }
    return std::abs(sum);
  }

  const Image& image_;
  const std::vector<float>& errors_;
  const CpuReceivers* pixels_;
  std::vector<double> sizes_;  // of a tile's differences
};

}  // namespace

PictureError ExpectPictureError(const Image& visibility_and_share, const std::vector<float>& errors,
                                const CpuReceivers* pixels) {
  Picture picture(visibility_and_share, errors, pixels);
  PictureError total;
  for (int top = 0; top < visibility_and_share.height(); top += kTile) {
    for (int left = 0; left < visibility_and_share.width(); left += kTile) picture.AddTile(left, top, &total);
  }
  return total;
}

}  // namespace halfshade
