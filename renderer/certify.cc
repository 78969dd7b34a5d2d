#include "renderer/certify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include "renderer/light/trace_light.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr float kLit = 1 - kPenumbraMargin;  // from here on v is light
constexpr int kTileSize = 8;
constexpr size_t kTilePixels = 64;

// What the request's own rays use must not be used again: their errors would agree.
constexpr uint32_t kSeedA = 0x9e3779b9u;
constexpr uint32_t kSeedB = 0x85ebca6bu;

// One at random from each of `count` equal stretches.
void ChooseFrom(const std::vector<uint32_t>& pixels, size_t count, uint32_t stratum, std::mt19937& random,
                std::vector<ChosenPixel>& chosen) {
  count = std::min(count, pixels.size());
  for (size_t i = 0; i < count; ++i) {
    const size_t first = i * pixels.size() / count;
    const size_t last = (i + 1) * pixels.size() / count;
    chosen.push_back({pixels[first + random() % (last - first)], double(last - first), stratum});
  }
}

// Sums of a weighted mean over the shadowed.
struct Sums {
  double weight = 0;
  double error = 0;     // |v - (a + b)/2|
  double crossing = 0;  // sign(v - a) (v - b), both ways
  void Add(const CertifiedPixel& pixel) {
    const double a = pixel.tested - pixel.traced_a;
    const double b = pixel.tested - pixel.traced_b;
    const auto sign = [](double x) { return double(x > 0) - double(x < 0); };
    weight += pixel.weight;
    error += pixel.weight * std::abs(a + b) / 2;
    crossing += pixel.weight * (sign(a) * b + sign(b) * a) / 2;
  }
};

bool IsShadowed(const CertifiedPixel& pixel) { return (pixel.traced_a + pixel.traced_b) / 2 < kLit; }

// The value below which `share` of the sorted values lie.
double Quantile(std::vector<double>& values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, size_t(share * double(values.size())))];
}

}  // namespace

std::vector<ChosenPixel> ChoosePixels(const Image& visibility_and_share, uint32_t count, uint32_t seed) {
  const int width = visibility_and_share.width();
  const int height = visibility_and_share.height();
  const float* const pairs = visibility_and_share.data();
  const auto visibility = [pairs](size_t pixel) { return pairs[2 * pixel]; };
  const auto share = [pairs](size_t pixel) { return pairs[2 * pixel + 1]; };
  // The render says shadow; it says light in a tile that has shadow; it says light elsewhere.
  std::array<std::vector<uint32_t>, kStrata> strata;
  // Tile after tile, so that equal stretches of a list are patches of the picture.
  for (int top = 0; top < height; top += kTileSize) {
    for (int left = 0; left < width; left += kTileSize) {
      std::array<uint32_t, kTilePixels> lit;
      size_t lit_count = 0;
      const size_t shadowed_before = strata[0].size();
      for (int y = top; y < std::min(top + kTileSize, height); ++y) {
        for (int x = left; x < std::min(left + kTileSize, width); ++x) {
          const uint32_t pixel = uint32_t(y) * uint32_t(width) + uint32_t(x);
          if (share(pixel) <= 0) continue;
          if (visibility(pixel) < kLit) {
            strata[0].push_back(pixel);
          } else {
            lit[lit_count++] = pixel;
          }
        }
      }
      std::vector<uint32_t>& stratum = strata[strata[0].size() > shadowed_before ? 1 : 2];
      stratum.insert(stratum.end(), lit.begin(), lit.begin() + lit_count);
    }
  }
  // The smallest first: what one does not need, the others share.
  std::array<uint32_t, kStrata> order = {0, 1, 2};
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return strata[a].size() < strata[b].size(); });
  std::mt19937 random(seed);
  std::vector<ChosenPixel> chosen;
  for (uint32_t i = 0; i < kStrata; ++i) {
    const size_t left = count - std::min<size_t>(count, chosen.size());
    ChooseFrom(strata[order[i]], (left + kStrata - i - 1) / (kStrata - i), order[i], random, chosen);
  }
  return chosen;
}

absl::StatusOr<std::vector<CertifiedPixel>> CertifyPixels(const RayScene& scene, const AreaLight& side,
                                                          const CpuReceivers& pixels,
                                                          const std::vector<ChosenPixel>& chosen,
                                                          const Image& visibility_and_share, int rays, uint32_t seed,
                                                          const std::function<absl::Status()>& stop) {
  std::vector<uint32_t> indices;
  for (const ChosenPixel& pixel : chosen) indices.push_back(pixel.index);
  const CpuReceivers receivers = SelectReceivers(pixels, indices);
  ASSIGN_OR_RETURN(const TracedLight a,
                   TraceLight(scene, side, receivers, {.rays = rays, .seed = seed ^ kSeedA}, stop));
  ASSIGN_OR_RETURN(const TracedLight b,
                   TraceLight(scene, side, receivers, {.rays = rays, .seed = seed ^ kSeedB}, stop));
  std::vector<CertifiedPixel> certified;
  for (size_t i = 0; i < chosen.size(); ++i) {
    certified.push_back({chosen[i].weight, chosen[i].stratum, visibility_and_share.data()[2 * size_t{chosen[i].index}],
                         a.visibility[i], b.visibility[i]});
  }
  return certified;
}

Certificate EstimateError(const std::vector<CertifiedPixel>& pixels, uint32_t seed) {
  Certificate certificate;
  certificate.pixels = pixels.size();
  std::map<uint32_t, std::vector<const CertifiedPixel*>> strata;
  Sums sums;
  double noise = 0;
  double weight_all = 0;
  double squares = 0;
  for (const CertifiedPixel& pixel : pixels) {
    strata[pixel.stratum].push_back(&pixel);
    weight_all += pixel.weight;
    squares += pixel.weight * (pixel.tested - pixel.traced_a) * (pixel.tested - pixel.traced_b);
    if (!IsShadowed(pixel)) continue;
    ++certificate.shadowed;
    sums.Add(pixel);
    noise += pixel.weight * std::abs(pixel.traced_a - pixel.traced_b) / 2;
  }
  if (weight_all > 0) certificate.rmse_all = std::sqrt(std::max(0.0, squares / weight_all));
  if (sums.weight == 0) return certificate;
  certificate.measured = sums.error / sums.weight;
  certificate.noise = noise / sums.weight;

  // Enough for a quantile, and no more than some tens of milliseconds.
  const int resamples = int(std::clamp<size_t>((4u << 20) / pixels.size(), 200, 1000));
  std::mt19937 random(seed);
  std::vector<double> errors, crossings;
  for (int i = 0; i < resamples; ++i) {
    Sums drawn;
    for (const auto& [stratum, members] : strata) {
      for (size_t j = 0; j < members.size(); ++j) {
        const CertifiedPixel& pixel = *members[random() % members.size()];
        if (IsShadowed(pixel)) drawn.Add(pixel);
      }
    }
    if (drawn.weight == 0) continue;
    errors.push_back(drawn.error / drawn.weight);
    crossings.push_back(drawn.crossing / drawn.weight);
  }
  if (errors.empty()) return certificate;
  certificate.ci95 =
      std::max(Quantile(errors, 0.975) - *certificate.measured, *certificate.measured - Quantile(crossings, 0.025));
  return certificate;
}

void ReportCertificate(const Certificate& certificate, RenderReport& report) {
  PassReport& pass = report.passes.emplace_back(PassReport{.name = "certificate", .count = certificate.shadowed});
  if (!certificate.measured) {
    pass.reason = certificate.pixels == 0 ? "no pixel faces a light" : "rays see no shadow at any of the pixels";
    return;
  }
  report.error.measured = certificate.measured;
  report.error.ci95 = certificate.ci95;
  report.error.noise = certificate.noise;
  pass.reason = std::to_string(certificate.shadowed) + " of " + std::to_string(certificate.pixels) +
                " pixels are in shadow; rmse_all " + std::to_string(certificate.rmse_all);
  if (certificate.IsLimitedByNoise()) pass.reason += "; limited by noise: more rays would tell more";
}

}  // namespace halfshade
