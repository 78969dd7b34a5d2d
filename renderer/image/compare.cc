#include "renderer/image/compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "renderer/report.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr double kSigma = 1.5;
constexpr double kC1 = 0.01 * 0.01;
constexpr double kC2 = 0.03 * 0.03;
constexpr int kRadius = kSsimWindow / 2;

std::string SizeText(const Image& image) {
  return std::to_string(image.width()) + " x " + std::to_string(image.height()) + " x " +
         std::to_string(image.channels());
}

absl::Status CheckFinite(const char* name, const Image& image) {
  const float* end = image.data() + image.size();
  const float* found = std::find_if(image.data(), end, [](float value) { return !std::isfinite(value); });
  if (found == end) return absl::OkStatus();
  const auto pixel = (found - image.data()) / image.channels();
  return absl::InvalidArgumentError(std::string(name) + ": the value at pixel " +
                                    std::to_string(pixel % image.width()) + "," +
                                    std::to_string(pixel / image.width()) + " is not finite");
}

absl::Status CheckInputs(const Image& reference, const Image& tested, const Image* mask) {
  if (reference.width() != tested.width() || reference.height() != tested.height() ||
      reference.channels() != tested.channels()) {
    return absl::InvalidArgumentError("sizes differ: the reference has " + SizeText(reference) +
                                      " (width x height x channels), the other image " + SizeText(tested));
  }
  if (mask != nullptr &&
      (mask->width() != reference.width() || mask->height() != reference.height() || mask->channels() != 1)) {
    return absl::InvalidArgumentError("sizes differ: the images have " + SizeText(reference) +
                                      " (width x height x channels), the mask " + SizeText(*mask) +
                                      "; it needs the same width and height, and one channel");
  }
  RETURN_IF_ERROR(CheckFinite("reference", reference));
  return CheckFinite("tested", tested);
}

bool IsIn(const Image* mask, int x, int y) { return mask == nullptr || mask->at(x, y, 0) > 0; }

// Sum of absolute errors over a set.
struct Sum {
  uint64_t count = 0;
  double absolute = 0;
  void Add(double error) {
    ++count;
    absolute += error;
  }
  std::optional<double> Mean() const {
    return count == 0 ? std::nullopt : std::optional<double>(absolute / double(count));
  }
};

std::array<double, kSsimWindow> GaussianWindow() {
  std::array<double, kSsimWindow> weights{};
  double sum = 0;
  for (int i = 0; i < kSsimWindow; ++i) {
    weights[size_t(i)] = std::exp(-(i - kRadius) * (i - kRadius) / (2 * kSigma * kSigma));
    sum += weights[size_t(i)];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

// Weighted sums of value(x, y) over the windows that lie inside; rows, then columns.
template <typename Value>
std::vector<double> Blur(int width, int height, Value value) {
  static const std::array<double, kSsimWindow> kWeights = GaussianWindow();
  const int out_width = width - 2 * kRadius, out_height = height - 2 * kRadius;
  std::vector<double> rows(size_t(out_width) * size_t(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < out_width; ++x) {
      double sum = 0;
      for (int i = 0; i < kSsimWindow; ++i) sum += kWeights[size_t(i)] * value(x + i, y);
      rows[size_t(y) * size_t(out_width) + size_t(x)] = sum;
    }
  }
  std::vector<double> result(size_t(out_width) * size_t(out_height));
  for (int y = 0; y < out_height; ++y) {
    for (int x = 0; x < out_width; ++x) {
      double sum = 0;
      for (int i = 0; i < kSsimWindow; ++i) {
        sum += kWeights[size_t(i)] * rows[size_t(y + i) * size_t(out_width) + size_t(x)];
      }
      result[size_t(y) * size_t(out_width) + size_t(x)] = sum;
    }
  }
  return result;
}

std::optional<double> MeanSsim(const Image& a, const Image& b, const Image* mask) {
  Sum similarity;
  for (int c = 0; c < a.channels(); ++c) {
    const Image map = Ssim(a, b, c);
    for (int y = 0; y < map.height(); ++y) {
      for (int x = 0; x < map.width(); ++x) {
        if (IsIn(mask, x + kRadius, y + kRadius)) similarity.Add(map.at(x, y, 0));
      }
    }
  }
  return similarity.Mean();
}

}  // namespace

Image Ssim(const Image& a, const Image& b, int channel) {
  const int width = a.width(), height = a.height();
  if (width < kSsimWindow || height < kSsimWindow) return Image();
  const auto at_a = [&](int x, int y) { return double(a.at(x, y, channel)); };
  const auto at_b = [&](int x, int y) { return double(b.at(x, y, channel)); };
  const auto mean_a = Blur(width, height, at_a);
  const auto mean_b = Blur(width, height, at_b);
  const auto mean_aa = Blur(width, height, [&](int x, int y) { return at_a(x, y) * at_a(x, y); });
  const auto mean_bb = Blur(width, height, [&](int x, int y) { return at_b(x, y) * at_b(x, y); });
  const auto mean_ab = Blur(width, height, [&](int x, int y) { return at_a(x, y) * at_b(x, y); });
  Image map(width - 2 * kRadius, height - 2 * kRadius, 1);
  for (size_t i = 0; i < map.size(); ++i) {
    const double product = mean_a[i] * mean_b[i];
    const double squares = mean_a[i] * mean_a[i] + mean_b[i] * mean_b[i];
    const double covariance = mean_ab[i] - product;
    const double variances = mean_aa[i] + mean_bb[i] - squares;
    map.data()[i] = float((2 * product + kC1) * (2 * covariance + kC2) / ((squares + kC1) * (variances + kC2)));
  }
  return map;
}

absl::StatusOr<ImageError> Compare(const Image& reference, const Image& tested, const Image* mask) {
  RETURN_IF_ERROR(CheckInputs(reference, tested, mask));
  Sum all, shadowed, penumbra;
  double squares = 0;
  std::vector<float> errors;
  errors.reserve(reference.size());
  for (int y = 0; y < reference.height(); ++y) {
    for (int x = 0; x < reference.width(); ++x) {
      if (!IsIn(mask, x, y)) continue;
      for (int c = 0; c < reference.channels(); ++c) {
        const double v = reference.at(x, y, c);
        const double error = std::abs(double(tested.at(x, y, c)) - v);
        all.Add(error);
        squares += error * error;
        if (v < 1 - kPenumbraMargin) shadowed.Add(error);
        if (v > kPenumbraMargin && v < 1 - kPenumbraMargin) penumbra.Add(error);
        errors.push_back(float(error));
      }
    }
  }
  ImageError result;
  result.samples_all = all.count;
  result.samples_shadowed = shadowed.count;
  result.samples_penumbra = penumbra.count;
  result.mae_all = all.Mean();
  result.mae_shadowed = shadowed.Mean();
  result.mae_penumbra = penumbra.Mean();
  if (all.count == 0) return result;
  const double mse = squares / double(all.count);
  result.rmse_all = std::sqrt(mse);
  result.psnr_all = mse > 0 ? 10 * std::log10(1 / mse) : std::numeric_limits<double>::infinity();
  result.ssim_all = MeanSsim(reference, tested, mask);
  const size_t rank = size_t(std::ceil(0.999 * double(errors.size()))) - 1;
  std::nth_element(errors.begin(), errors.begin() + ptrdiff_t(rank), errors.end());
  result.p999 = errors[rank];
  result.max = *std::max_element(errors.begin() + ptrdiff_t(rank), errors.end());
  return result;
}

}  // namespace halfshade
