// The certificate: how far a render's visibility is from what rays see, measured at random pixels.
//
// Pixels come from all that face a light: a third each from where the render says shadow, from light in the same tile,
// and from other light (else small shadows are missed, and wrongly lit pixels never seen). Each third is spread evenly
// over the picture and weighed by how many pixels one stands for. Two independent sets of rays a and b look at each, so
// that the rays' own noise is known. Pure but for the rays; deterministic for a seed.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "renderer/image/image.h"
#include "renderer/light/cpu_receivers.h"
#include "renderer/report.h"
#include "renderer/request.h"
#include "renderer/scene/ray_scene.h"

namespace halfshade {

// A pixel of one side of a light.
struct ChosenPixel {
  uint32_t index = 0;    // row * width + column
  double weight = 1;     // pixels that it stands for
  uint32_t stratum = 0;  // of those that the bootstrap draws from together
};

// Strata of one side of a light: 0 to kStrata - 1.
inline constexpr uint32_t kStrata = 3;

// About `count` of the pixels whose share is over 0, or all of them if there are no more. `visibility_and_share`:
// [height][width][2], as FinishVisibility returns it.
std::vector<ChosenPixel> ChoosePixels(const Image& visibility_and_share, uint32_t count, uint32_t seed);

struct CertifiedPixel {
  double weight = 1;
  uint32_t stratum = 0;
  double tested = 1;    // the render's v
  double traced_a = 1;  // by one set of rays
  double traced_b = 1;  // by the other
};

// Traces the chosen pixels of one side of a light. `pixels`: the receivers of the whole picture. Errors: of `stop`.
absl::StatusOr<std::vector<CertifiedPixel>> CertifyPixels(const RayScene& scene, const AreaLight& side,
                                                          const CpuReceivers& pixels,
                                                          const std::vector<ChosenPixel>& chosen,
                                                          const Image& visibility_and_share, int rays, uint32_t seed,
                                                          const std::function<absl::Status()>& stop);

struct Certificate {
  uint64_t pixels = 0;             // traced
  uint64_t shadowed = 0;           // of those, traced v < 1 - 1/512
  std::optional<double> measured;  // mean |error| over the shadowed; absent if there are none
  // Half width of the interval around `measured` that holds the true figure in 95 of 100 cases: a bootstrap over pixels
  // of two estimates that lie on either side of it, mean |v - (a + b)/2|, which the rays' noise raises, and mean
  // sign(v - a) (v - b), which it lowers.
  double ci95 = 0;
  double noise = 0;     // mean |a - b| / 2 over the shadowed
  double rmse_all = 0;  // sqrt(max(0, mean (v - a)(v - b))) over all that face the light, which noise does not bias
  bool IsLimitedByNoise() const { return measured && noise > *measured / 2; }
};

Certificate EstimateError(const std::vector<CertifiedPixel>& pixels, uint32_t seed);

// Into report.error, and what has no field there into a pass "certificate", which counts the shadowed.
void ReportCertificate(const Certificate& certificate, RenderReport& report);

}  // namespace halfshade
