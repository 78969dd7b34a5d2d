#include "renderer/image/surface_filter.h"

#include <algorithm>

namespace halfshade {

Image FilterAlongSurfaces(const Image& values, const Surfaces& surfaces, int radius) {
  Image result = values;
  const int width = values.width(), height = values.height();
  const auto are_one_surface = [&](size_t a, size_t b) {
    return AreOneSurface(surfaces.normals[a], surfaces.points[a], surfaces.normals[b], surfaces.points[b]);
  };
  for (int y = 0; y < height; ++y) {
    const int top = std::max(0, y - radius), bottom = std::min(height - 1, y + radius);
    for (int x = 0; x < width; ++x) {
      const int left = std::max(0, x - radius), right = std::min(width - 1, x + radius);
      const size_t middle = size_t(y) * width + x;
      const float value = values.data()[middle];
      // Most of a picture is all lit or all dark.
      bool is_even = true;
      for (int j = top; j <= bottom && is_even; ++j) {
        for (int i = left; i <= right; ++i) is_even = is_even && values.data()[size_t(j) * width + i] == value;
      }
      if (is_even) continue;
      float sum = value;
      int count = 1;
      for (int j = top; j <= bottom; ++j) {
        for (int i = left; i <= right; ++i) {
          const size_t other = size_t(j) * width + i;
          if (other == middle || !are_one_surface(middle, other)) continue;
          sum += values.data()[other];
          ++count;
        }
      }
      result.data()[middle] = sum / float(count);
    }
  }
  return result;
}

}  // namespace halfshade
