#include "renderer/light/trace_filtered.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "renderer/image/surface_filter.h"
#include "renderer/light/lit_receivers.h"
#include "renderer/light/parallel_for.h"
#include "renderer/math/camera.h"
#include "renderer/math/sampling.h"
#include "renderer/scene/ray_fan.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr int kSide = 4;  // pixels of a block
constexpr int kPixels = kSide * kSide;
static_assert(kPixels == RayPacket::kSegments);
constexpr int kReach = 2;            // of the mean, pixels to each side
constexpr int kTileSide = 4;         // blocks of a tile: in a row by one thread
constexpr int kMostRoundRays = 256;  // of a pixel: about 2 ms of a tile, stays below the stop check's period
constexpr float kWeights[kReach + 1] = {1, 1, 0.5f};
constexpr float kNarrowWeights[kReach + 1] = {1, 0.5f, 0};  // over 2 x 2 pixels' worth, with a third of the blur
constexpr float kErrorRate = 0.7f;                          // of stratified rays, as ExpectedTraceError
// By so much, times rays^-.75, may a mean be off what the pixel's own rays say. Less lets their noise through (at half
// of it one ray errs by 1.7 times as much), more the blur (at 1.5 times of it p999 of flight_helmet at 16 rays is .18
// and not .12).
constexpr float kMostOff = 0.9f;
// Blur, of what a mean and the narrow one differ by: second moments 1.5 and .5 along each axis.
constexpr float kBlurOfDifference = 1.5f;

// Of each sixteen points in a row of the sequence, which are stratified by themselves, one is one pixel's: the p-th of
// the first, the (p ^ TurnOf(i))-th of the i-th sixteen. With these turns (found by trying) the points of each pixel
// are stratified too: the first 2, 4, ... 64 are a (0, m, 2)-net in base 2.
int TurnOf(int round) {
  static constexpr int kTurns[] = {3, 6, 12, 11, 5, 10};  // of a bit of the round
  int turn = 0;
  for (const int& of_bit : kTurns) {
    if ((round >> (&of_bit - kTurns) & 1) != 0) turn ^= of_bit;
  }
  return turn;
}

// What a pixel's rays met.
struct Tally {
  int above = 0;   // their points on the light stand above the pixel's plane
  int hidden = 0;  // and something is between
};

// Points of the eye's rays on planes, relative to the eye, in floats.
class PixelPoints {
 public:
  explicit PixelPoints(const CpuReceivers& pixels)
      : pixels_(pixels), ray_from_ndc_(RayFromNdc(pixels.camera, double(pixels.width) / pixels.height)) {}
  glm::vec3 At(int x, int y, const glm::vec4& plane) const {
    const float ndc_x = 2 * (float(x) + 0.5f) / float(pixels_.width) - 1;
    const float ndc_y = 1 - 2 * (float(y) + 0.5f) / float(pixels_.height);
    const glm::vec3 across = ray_from_ndc_[0] * ndc_x + ray_from_ndc_[1] * ndc_y;
    const glm::vec3 origin = pixels_.camera.is_orthographic ? across : glm::vec3(0);
    const glm::vec3 ray = pixels_.camera.is_orthographic ? ray_from_ndc_[2] : across + ray_from_ndc_[2];
    const glm::vec3 normal(plane);
    return origin + ray * ((plane.w - glm::dot(normal, origin)) / glm::dot(normal, ray));
  }

 private:
  const CpuReceivers& pixels_;
  glm::mat3 ray_from_ndc_;
};

class FilteredTracer {
 public:
  FilteredTracer(const RayScene& scene, const AreaLight& light, const CpuReceivers& pixels,
                 const FilteredTraceOptions& options)
      : scene_(scene),
        light_(light),
        pixels_(pixels),
        options_(options),
        points_(pixels),
        columns_((pixels.width + kSide - 1) / kSide),
        rows_((pixels.height + kSide - 1) / kSide),
        tile_columns_((columns_ + kTileSide - 1) / kTileSide),
        tallies_(pixels.size()),
        meets_(size_t(columns_) * rows_),
        center_(scene.TraceFromWorld(light.center_ws)),
        edge_u_(light.axis_u_ws * (light.width_m * scene.trace_scale())),
        edge_v_(light.axis_v_ws * (light.height_m * scene.trace_scale())) {
    for (int i = 0; i < kPixels * options.rays; ++i) {
      on_light_.push_back(glm::vec2(OwenSobol2(uint32_t(i), options.seed) - 0.5));
    }
  }

  absl::StatusOr<FilteredLight> Run(const std::function<absl::Status()>& stop) {
    ASSIGN_OR_RETURN(is_lit_, FindLit(scene_, light_, pixels_, ReceiversInTiles(pixels_), stop, options_.threads));
    // One ray tells penumbra; of so few as two nothing is saved.
    const int first = options_.rays <= 2 ? options_.rays : 1;
    RETURN_IF_ERROR(ForBlocks([&](int column, int row) { TraceBlock(column, row, 0, first); }, stop));
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) is_mixed_.push_back(uint8_t(IsMixedAround(column, row)));
    }
    RETURN_IF_ERROR(ForBlocks(
        [&](int column, int row) {
          if (!IsMixed(column, row)) Weigh(column, row, options_.rays / first);
        },
        stop));
    for (int begin = first; begin < options_.rays; begin += kMostRoundRays) {
      const int end = std::min(begin + kMostRoundRays, options_.rays);
      RETURN_IF_ERROR(ForBlocks(
          [&](int column, int row) {
            if (IsMixed(column, row)) TraceBlock(column, row, begin, end);
          },
          stop));
    }
    result_.hidden.resize(pixels_.size());
    result_.errors.resize(pixels_.size());
    RETURN_IF_ERROR(ForBlocks([&](int column, int row) { FilterBlock(column, row); }, stop));
    result_.rays = rays_;
    result_.lit = uint64_t(std::count(is_lit_.begin(), is_lit_.end(), 1));
    return std::move(result_);
  }

 private:
  // In tiles, which share nodes of the hierarchy.
  template <typename Work>
  absl::Status ForBlocks(const Work& work, const std::function<absl::Status()>& stop) const {
    const int tiles = tile_columns_ * ((rows_ + kTileSide - 1) / kTileSide);
    const auto do_tile = [&](int tile) {
      const int left = tile % tile_columns_ * kTileSide, top = tile / tile_columns_ * kTileSide;
      for (int row = top; row < std::min(top + kTileSide, rows_); ++row) {
        for (int column = left; column < std::min(left + kTileSide, columns_); ++column) work(column, row);
      }
    };
    return ParallelFor(tiles, 1, do_tile, stop, options_.threads);
  }

  // work(lane, x, y, index) for the block's pixels that receive.
  template <typename Work>
  void ForPixels(int column, int row, const Work& work) const {
    for (int lane = 0; lane < kPixels; ++lane) {
      const int x = column * kSide + lane % kSide, y = row * kSide + lane / kSide;
      if (x >= pixels_.width || y >= pixels_.height) continue;
      const size_t index = size_t(y) * pixels_.width + x;
      if (pixels_.IsReceiving(index)) work(lane, x, y, index);
    }
  }

  // The point on the light of a pixel's i-th ray. A block begins with other points than those around, so that together
  // they say where penumbra is.
  const glm::vec2& OnLight(int column, int row, int lane, int i) const {
    static constexpr int kAlongZ[kPixels] = {0, 1, 4, 5, 2, 3, 6, 7, 8, 9, 12, 13, 10, 11, 14, 15};
    const int round = (i + column % 4 + row % 4 * 4) % options_.rays;
    return on_light_[size_t(round * kPixels + (kAlongZ[lane] ^ TurnOf(round)))];
  }

  // Rays [first, last) of each pixel.
  void TraceBlock(int column, int row, int first, int last) {
    RayBundle bundle(scene_);
    std::fill_n(bundle.is_wanted(), kPixels, 0);
    glm::vec3 to_center[kPixels], height[kPixels];
    size_t index[kPixels];
    uint32_t active = 0, meets = 0;
    ForPixels(column, row, [&](int lane, int, int, size_t i) {
      index[lane] = i;
      if (is_lit_[i] != 0) {
        tallies_[i].above += last - first;
        meets |= kMeetsLight;
        return;
      }
      const CpuReceiver receiver = pixels_.At(i);
      const LightAbovePlane cut = CutAtPlane(light_, pixels_, receiver);
      if (cut.share <= 0) return;
      const glm::vec3 origin(scene_.TraceFromWorld(receiver.position_ws));
      bundle.SetOrigin(lane, {origin, glm::vec3(receiver.normal_ws), float(PlaneError(scene_, pixels_, receiver))});
      to_center[lane] = glm::vec3(center_ - glm::dvec3(origin));
      height[lane] = glm::vec3(cut.along_u, cut.along_v, cut.middle);
      active |= 1u << lane;
    });
    uint64_t rays = 0;
    for (int i = first; i < last && active != 0; ++i) {
      uint32_t wanted = 0;
      for (uint32_t lanes = active; lanes != 0; lanes &= lanes - 1) {
        const int lane = std::countr_zero(lanes);
        const glm::vec2& point = OnLight(column, row, lane, i);
        const glm::vec3 direction = to_center[lane] + edge_u_ * point.x + edge_v_ * point.y;
        bundle.direction_x()[lane] = direction.x;
        bundle.direction_y()[lane] = direction.y;
        bundle.direction_z()[lane] = direction.z;
        const bool is_above = height[lane].x * point.x + height[lane].y * point.y + height[lane].z > 0;
        bundle.is_wanted()[lane] = is_above ? -1 : 0;
        tallies_[index[lane]].above += is_above;
        wanted |= uint32_t(is_above) << lane;
      }
      const uint32_t hidden = bundle.FindOccluded();
      for (uint32_t lanes = hidden; lanes != 0; lanes &= lanes - 1) ++tallies_[index[std::countr_zero(lanes)]].hidden;
      rays += uint64_t(std::popcount(wanted));
      meets |= (hidden != 0 ? kMeetsOccluder : 0u) | (hidden != wanted ? kMeetsLight : 0u);
    }
    rays_ += rays;
    meets_[size_t(row) * columns_ + column] |= uint8_t(meets);
  }

  bool IsMixedAround(int column, int row) const {
    uint32_t meets = 0;
    for (int j = std::max(0, row - 1); j <= std::min(rows_ - 1, row + 1); ++j) {
      for (int i = std::max(0, column - 1); i <= std::min(columns_ - 1, column + 1); ++i) {
        meets |= meets_[size_t(j) * columns_ + i];
      }
    }
    return meets == (kMeetsLight | kMeetsOccluder);
  }
  bool IsMixed(int column, int row) const { return is_mixed_[size_t(row) * columns_ + column] != 0; }

  // As if `times` as many rays had been traced, to the same end.
  void Weigh(int column, int row, int times) {
    ForPixels(column, row, [&](int, int, int, size_t i) {
      tallies_[i].above *= times;
      tallies_[i].hidden *= times;
    });
  }

  void FilterBlock(int column, int row) {
    const bool is_hidden = meets_[size_t(row) * columns_ + column] == kMeetsOccluder;
    ForPixels(column, row, [&](int, int x, int y, size_t i) {
      if (is_lit_[i] != 0) return;
      if (!IsMixed(column, row)) {
        result_.hidden[i] = is_hidden ? 1 : 0;
      } else {
        FilterPixel(x, y, i);
      }
    });
  }

  void FilterPixel(int x, int y, size_t i) {
    const glm::vec3 normal(pixels_.planes[i]), point = points_.At(x, y, pixels_.planes[i]);
    float above = 0, hidden = 0, narrow_above = 0, narrow_hidden = 0;
    for (int v = std::max(0, y - kReach); v <= std::min(pixels_.height - 1, y + kReach); ++v) {
      for (int u = std::max(0, x - kReach); u <= std::min(pixels_.width - 1, x + kReach); ++u) {
        const size_t other = size_t(v) * pixels_.width + u;
        const Tally& tally = tallies_[other];
        if (tally.above == 0) continue;
        const glm::vec4& plane = pixels_.planes[other];
        if (other != i && !AreOneSurface(normal, point, glm::vec3(plane), points_.At(u, v, plane))) continue;
        const int across = std::abs(u - x), down = std::abs(v - y);
        const float weight = kWeights[across] * kWeights[down];
        const float narrow_weight = kNarrowWeights[across] * kNarrowWeights[down];
        above += weight * float(tally.above);
        hidden += weight * float(tally.hidden);
        narrow_above += narrow_weight * float(tally.above);
        narrow_hidden += narrow_weight * float(tally.hidden);
      }
    }
    const Tally& own = tallies_[i];
    if (above == 0) {  // so little of the light is above that no ray went there
      result_.hidden[i] = 1;
      return;
    }
    float mean = hidden / above;
    float error = NoiseOf(mean, above);
    if (narrow_above > 0) {
      const float difference = std::abs(narrow_hidden / narrow_above - mean);
      error += kBlurOfDifference * std::max(0.0f, difference - NoiseOf(mean, narrow_above));
    }
    if (own.above > 0) {
      const float alone = float(own.hidden) / float(own.above);
      const float most_off = kMostOff * std::pow(float(own.above), -0.75f);
      mean = std::clamp(mean, alone - most_off, alone + most_off);
      error = std::min(error, most_off);
    }
    result_.hidden[i] = std::clamp(mean, 0.0f, 1.0f);
    result_.errors[i] = error;
  }

  static float NoiseOf(float fraction, float rays) {
    return kErrorRate * std::sqrt(fraction * (1 - fraction)) * std::pow(rays, -0.75f);
  }

  static constexpr uint32_t kMeetsLight = 1, kMeetsOccluder = 2;

  const RayScene& scene_;
  const AreaLight& light_;
  const CpuReceivers& pixels_;
  const FilteredTraceOptions& options_;
  const PixelPoints points_;
  const int columns_, rows_, tile_columns_;  // blocks, and tiles of them
  std::vector<Tally> tallies_;
  std::vector<uint8_t> meets_;     // a block's rays: kMeetsLight, kMeetsOccluder
  std::vector<uint8_t> is_mixed_;  // of a block and those around: after the first rays
  std::vector<uint8_t> is_lit_;    // a pixel: nothing stands between its tile and the light
  const glm::dvec3 center_;        // trace space
  const glm::vec3 edge_u_, edge_v_;
  std::vector<glm::vec2> on_light_;  // of its edges, from its middle
  std::atomic<uint64_t> rays_ = 0;
  FilteredLight result_;
};

}  // namespace

absl::StatusOr<FilteredLight> TraceFiltered(const RayScene& scene, const AreaLight& light, const CpuReceivers& pixels,
                                            const FilteredTraceOptions& options,
                                            const std::function<absl::Status()>& stop) {
  return FilteredTracer(scene, light, pixels, options).Run(stop);
}

}  // namespace halfshade
