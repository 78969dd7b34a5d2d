#include "renderer/light/trace_light.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "renderer/light/lit_receivers.h"
#include "renderer/light/parallel_for.h"
#include "renderer/math/sampling.h"
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

std::vector<Round> MakeRounds(int rays, bool is_adaptive, uint32_t seed) {
  std::vector<Round> rounds;
  for (int first = 0; first < rays;) {
    const int wanted = !is_adaptive ? rays : first == 0 ? kFirstRays : first * kRoundGrowth;
    const int last = std::min({rays, wanted, first + kMaxRoundRays});
    rounds.push_back(MakeRound(first, last, seed));
    first = last;
  }
  return rounds;
}

// Rays of one receiver so far.
struct Tally {
  int above = 0;    // their points on the light stand above the receiver's plane
  int visible = 0;  // and nothing is between
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
    const std::vector<Round> rounds = MakeRounds(is_point ? 1 : options_.rays, options_.is_adaptive, options_.seed);
    TracedLight result;
    std::vector<uint32_t> active = ReceiversInTiles(receivers_);
    if (options_.skips_lit && options_.rays >= kFirstRays && !is_point) {
      ASSIGN_OR_RETURN(is_lit_, FindLit(scene_, light_, receivers_, active, stop, options_.threads));
    }
    result.lit = uint64_t(std::count(is_lit_.begin(), is_lit_.end(), 1));
    for (const Round& round : rounds) {
      const int grain = std::clamp(kGrainRays / (round.last - round.first), 1, kMostGrain);
      const auto trace = [&](int i) { TraceReceiver(active[size_t(i)], round); };
      RETURN_IF_ERROR(ParallelFor(int(active.size()), grain, trace, stop, options_.threads));
      const auto traced = std::count_if(active.begin(), active.end(), [&](uint32_t i) { return is_lit_[i] == 0; });
      result.rays += uint64_t(traced) * (round.last - round.first);
      if (options_.is_adaptive) active = WhereToGoOn(active, round.last);
    }
    result.hidden.resize(receivers_.size());
    result.errors.resize(receivers_.size());
    result.visibility.resize(receivers_.size(), 1);
    for (size_t i = 0; i < receivers_.size(); ++i) {
      result.hidden[i] = HiddenFraction(i);
      result.errors[i] = ErrorOf(tallies_[i]);
      if (receivers_.IsReceiving(i)) result.visibility[i] = tallies_[i].share * (1 - result.hidden[i]);
    }
    return result;
  }

 private:
  void TraceReceiver(uint32_t index, const Round& round) {
    const CpuReceiver receiver = receivers_.At(index);
    const LightAbovePlane cut = CutAtPlane(light_, receivers_, receiver);
    if (cut.share <= 0) return;
    Tally& tally = tallies_[index];
    tally.share = float(cut.share);
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

  // As ExpectedTraceError, but where many rays agree, they are believed: that is true of most of an umbra, and this is
  // for means.
  static float ErrorOf(const Tally& tally) {
    if (tally.above == 0 || (tally.above >= kFirstRays && !tally.IsMixed())) return 0;
    const double n = tally.above, v = tally.visible / n;
    const double variance = tally.above < kFirstRays ? Variance(tally.visible, tally.above) : v * (1 - v);
    return float(kMeanErrorRate * std::sqrt(variance / (n * std::sqrt(n))));
  }

  const RayScene& scene_;
  const AreaLight& light_;
  const CpuReceivers& receivers_;
  const TraceOptions& options_;
  glm::dvec3 center_;          // trace space
  glm::vec3 edge_u_, edge_v_;  // trace space, full edges
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
