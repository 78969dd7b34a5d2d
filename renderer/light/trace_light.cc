#include "renderer/light/trace_light.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>
#include <utility>

#include "renderer/light/lit_receivers.h"
#include "renderer/light/parallel_for.h"
#include "renderer/math/sampling.h"
#include "renderer/report.h"
#include "renderer/scene/ray_fan.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr int kLanes = RayFan::kSegments;
constexpr int kFirstRays = 16;  // of adaptive rounds, each of which multiplies them by ...
constexpr int kRoundGrowth = 4;
constexpr int kMaxRoundRays = 4096;      // about 2 ms at one receiver: stays far below the stop check's period
constexpr int kGrainRays = 2048;         // in a row by one thread: about 1 ms
constexpr int kMostGrain = 32;           // receivers of them
constexpr double kErrorRate = 0.7;       // of ExpectedTraceError
constexpr double kMeanErrorRate = 0.85;  // for rays that agree and are wrong all the same

// Of one ray, with one ray more on each side.
double Variance(int visible, int above) {
  const double v = (visible + 1.0) / (above + 2.0);
  return v * (1 - v);
}

// Two hashes of (seed, receiver): splitmix64 (Steele, Lea and Flood 2014).
glm::uvec2 ShiftOf(uint32_t seed, uint32_t index) {
  uint64_t x = ((uint64_t(seed) << 32) | index) + 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  x ^= x >> 31;
  return {uint32_t(x), uint32_t(x >> 32)};
}

uint32_t SpreadBits(uint32_t x) {
  x = (x | (x << 8)) & 0x00ff00ffu;
  x = (x | (x << 4)) & 0x0f0f0f0fu;
  x = (x | (x << 2)) & 0x33333333u;
  return (x | (x << 1)) & 0x55555555u;
}

// A 32-bit fraction of a light's edge, from its middle: [-1/2, 1/2), exact in a float.
float InLight(uint32_t fraction) { return float(int32_t(fraction >> 8)) * 5.9604645e-8f - 0.5f; }

// Points [first, last) of the sequence along a Z curve over the light, in 32-bit fractions, padded to whole packets.
struct Round {
  int first = 0;
  int last = 0;
  std::vector<uint32_t> x, y;
};

Round MakeRound(int first, int last, uint32_t seed) {
  std::vector<glm::uvec2> points;
  for (int i = first; i < last; ++i) {
    const glm::dvec2 point = OwenSobol2(uint32_t(i), seed);
    points.emplace_back(point * 4294967296.0);
  }
  std::sort(points.begin(), points.end(), [](const glm::uvec2& a, const glm::uvec2& b) {
    const auto key = [](const glm::uvec2& p) {
      return std::make_tuple(SpreadBits(p.x >> 16) | (SpreadBits(p.y >> 16) << 1), p.x, p.y);
    };
    return key(a) < key(b);
  });
  points.resize((points.size() + kLanes - 1) / kLanes * kLanes, points.back());
  Round round{first, last, {}, {}};
  for (const glm::uvec2& point : points) {
    round.x.push_back(point.x);
    round.y.push_back(point.y);
  }
  return round;
}

// Rays of one receiver so far.
struct Tally {
  int above = 0;    // their points on the light stand above the receiver's plane
  int visible = 0;  // and nothing is between
  int rays = 0;     // cast, those to points below it included
  float share = 0;  // of the light above the plane
  bool IsMixed() const { return visible > 0 && visible < above; }
};

class LightTracer {
 public:
  LightTracer(const RayScene& scene, const AreaLight& light, const CpuReceivers& receivers, const TraceOptions& options)
      : scene_(scene),
        light_(light),
        receivers_(receivers),
        options_(options),
        tallies_(receivers.size()),
        is_lit_(receivers.size()) {
    center_ = scene.TraceFromWorld(light.center_ws);
    edge_u_ = glm::vec3(light.axis_u_ws * (light.width_m * scene.trace_scale()));
    edge_v_ = glm::vec3(light.axis_v_ws * (light.height_m * scene.trace_scale()));
  }

  absl::StatusOr<TracedLight> Trace(const std::function<absl::Status()>& stop) {
    const bool is_point = light_.width_m == 0 && light_.height_m == 0;
    rays_ = is_point ? 1 : options_.rays;
    TracedLight result;
    order_ = ReceiversInTiles(receivers_);
    if (options_.skips_lit && options_.rays >= kFirstRays && !is_point) {
      ASSIGN_OR_RETURN(is_lit_, FindLit(scene_, light_, receivers_, order_, stop, options_.threads));
    }
    result.lit = uint64_t(std::count(is_lit_.begin(), is_lit_.end(), 1));
    // Receivers by the rounds that they have had.
    for (std::vector<std::vector<uint32_t>> next = {order_}; !next.empty(); next = WhoGoesOn(next)) {
      for (size_t had = 0; had < next.size(); ++had) {
        if (!next[had].empty()) RETURN_IF_ERROR(TraceRound(had, next[had], stop, &result));
      }
    }
    result.hidden.resize(receivers_.size());
    result.errors.resize(receivers_.size());
    result.visibility.resize(receivers_.size(), 1);
    for (size_t i = 0; i < receivers_.size(); ++i) {
      result.hidden[i] = HiddenFraction(i);
      if (tallies_[i].share > 0) result.errors[i] = ErrorOf(i) / tallies_[i].share;
      if (receivers_.IsReceiving(i)) result.visibility[i] = tallies_[i].share * (1 - result.hidden[i]);
    }
    return result;
  }

 private:
  absl::Status TraceRound(size_t index, const std::vector<uint32_t>& active, const std::function<absl::Status()>& stop,
                          TracedLight* result) {
    while (rounds_.size() <= index) {
      const int first = rounds_.empty() ? 0 : rounds_.back().last;
      rounds_.push_back(MakeRound(first, EndOfRound(first), options_.seed));
    }
    const Round& round = rounds_[index];
    const int count = round.last - round.first;
    const int grain = std::clamp(kGrainRays / count, 1, kMostGrain);
    const auto trace = [&](int i) { TraceReceiver(active[size_t(i)], round); };
    RETURN_IF_ERROR(ParallelFor(int(active.size()), grain, trace, stop, options_.threads));
    result->rays += uint64_t(std::count_if(active.begin(), active.end(), [&](uint32_t i) { return is_lit_[i] == 0; })) *
                    uint64_t(count);
    result->most_rays = std::max(result->most_rays, round.last);
    return absl::OkStatus();
  }

  // Of the round that begins with `first`.
  int EndOfRound(int first) const {
    const int wanted = !options_.is_adaptive ? rays_ : first == 0 ? kFirstRays : first * kRoundGrowth;
    return std::min({rays_, wanted, first + kMaxRoundRays});
  }

  // Who is to have another round, by the rounds that they have had: empty at the end.
  std::vector<std::vector<uint32_t>> WhoGoesOn(const std::vector<std::vector<uint32_t>>& had) const {
    if (rounds_.empty()) return {};  // nothing receives
    if (Decides()) {
      return rounds_.size() == 1 && rays_ > kFirstRays && !IsBelieved(kFirstRays) ? Probes() : WhereMostIsToGain();
    }
    const int rays = rounds_.back().last;
    if (rays == rays_) return {};
    std::vector<std::vector<uint32_t>> next(rounds_.size() + 1);
    next.back() = options_.is_adaptive ? WhereToGoOn(had.back(), rays) : had.back();
    if (next.back().empty()) return {};
    return next;
  }

  void TraceReceiver(uint32_t index, const Round& round) {
    const CpuReceiver receiver = receivers_.At(index);
    const LightAbovePlane cut = CutAtPlane(light_, receivers_, receiver);
    if (cut.share <= 0) return;
    Tally& tally = tallies_[index];
    tally.share = float(cut.share);
    tally.rays = round.last;
    const int count = round.last - round.first;
    if (is_lit_[index] != 0 && IsWhole(cut)) {
      tally.above += count;
      tally.visible += count;
      return;
    }
    const glm::vec3 origin(scene_.TraceFromWorld(receiver.position_ws));
    RayFan fan(scene_, {origin, glm::vec3(receiver.normal_ws), float(PlaneError(scene_, receivers_, receiver))});
    const glm::vec3 to_center(center_ - glm::dvec3(origin));
    const glm::uvec2 shift = ShiftOf(options_.seed, index);
    const glm::vec3 height(cut.along_u, cut.along_v, cut.middle);
    alignas(64) float heights[kLanes];
    int above = 0;
    int occluded = 0;
    for (int done = 0; done < count; done += kLanes) {
      for (int i = 0; i < kLanes; ++i) {
        const float a = InLight(round.x[done + i] ^ shift.x);
        const float b = InLight(round.y[done + i] ^ shift.y);
        fan.direction_x()[i] = to_center.x + edge_u_.x * a + edge_v_.x * b;
        fan.direction_y()[i] = to_center.y + edge_u_.y * a + edge_v_.y * b;
        fan.direction_z()[i] = to_center.z + edge_u_.z * a + edge_v_.z * b;
        heights[i] = height.x * a + height.y * b + height.z;
      }
      for (int i = 0; i < kLanes; ++i) fan.is_wanted()[i] = heights[i] > 0 ? -1 : 0;
      for (int i = count - done; i < kLanes; ++i) fan.is_wanted()[i] = 0;
      for (int i = 0; i < kLanes; ++i) above -= fan.is_wanted()[i];
      if (is_lit_[index] == 0) occluded += fan.CountOccluded();
    }
    tally.above += above;
    tally.visible += above - occluded;
  }

  // All points of the light are above the plane, in floats too.
  static bool IsWhole(const LightAbovePlane& cut) {
    constexpr double kRounding = 1e-5;
    const double slope = std::abs(cut.along_u) + std::abs(cut.along_v);
    return cut.middle - slope / 2 > kRounding * (cut.middle + slope);
  }

  // Receivers whose error is not small enough after `rays`. Pixels that agree with all their neighbours are done.
  std::vector<uint32_t> WhereToGoOn(const std::vector<uint32_t>& active, int rays) const {
    std::vector<uint32_t> next;
    const double least_variance = std::pow(options_.stop_error / (kErrorRate * std::pow(rays, -0.75)), 2);
    for (const uint32_t index : active) {
      const Tally& tally = tallies_[index];
      if (tally.above == 0 || Variance(tally.visible, tally.above) <= least_variance) continue;
      if (receivers_.ArePoints() || tally.IsMixed() || HasOtherNeighbour(index)) next.push_back(index);
    }
    return next;
  }

  // Their errors decide who goes on.
  bool Decides() const { return options_.is_adaptive && options_.mean_error > 0; }

  // So many rays that agree are off by no more than a few times the mean error where one ray more would not.
  bool IsBelieved(int rays) const {
    constexpr double kMostMeans = 4;
    return 1.0 / (rays + 2) <= kMostMeans * options_.mean_error;
  }

  // Of each block of receivers whose first rays agree, one, at a place of its own in each block.
  std::vector<std::vector<uint32_t>> Probes() const {
    std::vector<std::vector<uint32_t>> next(2);
    for (const uint32_t index : order_) {
      const Tally& tally = tallies_[index];
      if (tally.above > 0 && is_lit_[index] == 0 && !tally.IsMixed() && ProbeOf(index) == index)
        next[1].push_back(index);
    }
    return next[1].empty() ? WhereMostIsToGain() : next;
  }
  uint32_t ProbeOf(uint32_t index) const {
    constexpr uint32_t kSide = 4;  // of a block of pixels; of points a block is as many in a row
    if (receivers_.ArePoints()) {
      const uint32_t first = index / (kSide * kSide) * kSide * kSide;
      return std::min(first + ShiftOf(options_.seed, first).x % (kSide * kSide), uint32_t(receivers_.size() - 1));
    }
    const auto width = uint32_t(receivers_.width), height = uint32_t(receivers_.height);
    const uint32_t left = index % width / kSide * kSide, top = index / width / kSide * kSide;
    const glm::uvec2 place = ShiftOf(options_.seed, top * width + left);
    return std::min(top + place.y % kSide, height - 1) * width + std::min(left + place.x % kSide, width - 1);
  }

  // The receivers whose next rays gain most, each, as many as bring the mean over all that are shadowed below what is
  // asked for.
  std::vector<std::vector<uint32_t>> WhereMostIsToGain() const {
    constexpr double kBelow = 0.9;  // or the last rounds would be of a few receivers each
    struct Gain {
      double each;  // a ray
      double all;
      uint32_t receiver;
      bool operator<(const Gain& other) const {
        return each != other.each ? each > other.each : receiver < other.receiver;
      }
    };
    std::vector<Gain> gains;
    double sum = 0;
    uint64_t shadowed = 0;
    for (size_t i = 0; i < tallies_.size(); ++i) {
      const Tally& tally = tallies_[i];
      if (tally.above > 0 && HiddenFraction(i) > kPenumbraMargin) ++shadowed;
      const double error = ErrorOf(i);
      sum += error;
      if (error <= 0 || tally.rays >= rays_) continue;
      const int next = EndOfRound(tally.rays);
      const double gain = error * (1 - std::pow(double(tally.rays) / next, 0.75));
      gains.push_back({gain / (next - tally.rays), gain, uint32_t(i)});
    }
    if (sum <= options_.mean_error * double(shadowed)) return {};
    std::sort(gains.begin(), gains.end());
    std::vector<uint8_t> goes_on(tallies_.size());
    for (const Gain& gain : gains) {
      if (sum <= kBelow * options_.mean_error * double(shadowed)) break;
      sum -= gain.all;
      goes_on[gain.receiver] = 1;
    }
    std::vector<std::vector<uint32_t>> next;
    for (const uint32_t index : order_) {
      if (goes_on[index] == 0) continue;
      size_t had = 0;
      while (rounds_[had].last < tallies_[index].rays) ++had;
      if (next.size() < had + 2) next.resize(had + 2);
      next[had + 1].push_back(index);
    }
    return next;
  }

  // A neighbour's rays, or the more rays of its block's probe, are mixed or say otherwise.
  bool IsNearOther(uint32_t index) const {
    const Tally& own = tallies_[index];
    const Tally& probe = tallies_[ProbeOf(index)];
    if (probe.above > 0 && (probe.IsMixed() || (probe.visible > 0) != (own.visible > 0))) return true;
    return !receivers_.ArePoints() && HasOtherNeighbour(index);
  }

  // One of the eight pixels around is mixed, or seen where this one is hidden, or the other way round.
  bool HasOtherNeighbour(uint32_t index) const {
    const int x = int(index) % receivers_.width;
    const int y = int(index) / receivers_.width;
    const bool is_lit = tallies_[index].visible > 0;
    for (int row = std::max(0, y - 1); row <= std::min(receivers_.height - 1, y + 1); ++row) {
      for (int column = std::max(0, x - 1); column <= std::min(receivers_.width - 1, x + 1); ++column) {
        const Tally& other = tallies_[size_t(row) * receivers_.width + column];
        if (other.above > 0 && (other.IsMixed() || (other.visible > 0) != is_lit)) return true;
      }
    }
    return false;
  }

  float HiddenFraction(size_t index) const {
    const Tally& tally = tallies_[index];
    if (!receivers_.IsReceiving(index)) return 0;
    if (tally.above == 0) return 1;
    return float(tally.above - tally.visible) / float(tally.above);
  }

  // Of visibility: as ExpectedTraceError, but where many rays agree, they are believed: that is true of most of an
  // umbra, and this is for means. Where it decides who goes on, only if neighbours and probe agree too.
  float ErrorOf(size_t index) const {
    const Tally& tally = tallies_[index];
    if (tally.above == 0 || is_lit_[index] != 0) return 0;
    if (!tally.IsMixed() &&
        (Decides() ? IsBelieved(tally.above) || !IsNearOther(uint32_t(index)) : tally.above >= kFirstRays)) {
      return 0;
    }
    const double n = tally.above, v = tally.visible / n;
    const double variance = Decides() || tally.above < kFirstRays ? Variance(tally.visible, tally.above) : v * (1 - v);
    return tally.share * float(kMeanErrorRate * std::sqrt(variance / (n * std::sqrt(n))));
  }

  const RayScene& scene_;
  const AreaLight& light_;
  const CpuReceivers& receivers_;
  const TraceOptions& options_;
  glm::dvec3 center_;            // trace space
  glm::vec3 edge_u_, edge_v_;    // trace space, full edges
  int rays_ = 0;                 // the most at one receiver
  std::vector<uint32_t> order_;  // of the receivers, tile by tile
  std::vector<Round> rounds_;    // so far
  std::vector<Tally> tallies_;
  std::vector<uint8_t> is_lit_;  // 1: nothing stands between its tile and the light
};

}  // namespace

absl::StatusOr<TracedLight> TraceLight(const RayScene& scene, const AreaLight& light, const CpuReceivers& receivers,
                                       const TraceOptions& options, const std::function<absl::Status()>& stop) {
  return LightTracer(scene, light, receivers, options).Trace(stop);
}

double ExpectedTraceError(int visible, int above, int rays) {
  return kErrorRate * std::sqrt(Variance(visible, above)) * std::pow(rays, -0.75);
}

}  // namespace halfshade
