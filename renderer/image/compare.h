// How far one image is from another: every error figure of the project, over named sets of samples.
//
// A sample is a channel of a pixel; in a visibility image each channel is a light. Sets, by the reference's value v:
//   all         every sample that the mask lets in
//   shadowed    of those, v < 1 - 1/512: umbra and penumbra. mae_shadowed is the headline figure (Atty et al.
//   2006, 5.2.1) penumbra    1/512 < v < 1 - 1/512: tells what the umbra hides
// For visibility the mask should hold the pixels where something is drawn that faces part of the light: elsewhere both
// images agree by definition. Pure, on any thread; sums in double, in the image's order.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>

#include "renderer/image/image.h"

namespace halfshade {

// Absent: of an empty set.
struct ImageError {
  uint64_t samples_all = 0, samples_shadowed = 0, samples_penumbra = 0;
  std::optional<double> mae_shadowed, mae_penumbra, mae_all;  // mean absolute errors
  std::optional<double> rmse_all;
  std::optional<double> psnr_all;  // dB, peak 1; infinite where nothing differs
  std::optional<double> ssim_all;  // mean over Ssim() of the set
  std::optional<double> p999;      // of all: 99.9 % of the errors are at most this (nearest rank)
  std::optional<double> max;       // of all
};

// `mask`: null, or one channel of the same width and height; a pixel with a value over 0 is let in. INVALID_ARGUMENT
// for sizes or channels that differ (both are named) and for a value that is not finite.
absl::StatusOr<ImageError> Compare(const Image& reference, const Image& tested, const Image* mask);

// Structural similarity of one channel at each pixel whose window of 11 x 11 lies inside the image: Gaussian of
// sigma 1.5, K1 = .01, K2 = .03, peak 1. [height - 10][width - 10][1]; empty for a smaller image. Requires equal sizes.
// Source: Wang et al. 2004, "Image Quality Assessment: From Error Visibility to Structural Similarity", section III.
Image Ssim(const Image& a, const Image& b, int channel);

inline constexpr int kSsimWindow = 11;

}  // namespace halfshade
