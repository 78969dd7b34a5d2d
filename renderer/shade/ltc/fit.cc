#include "renderer/shade/ltc/fit.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/shade/ltc/ggx.h"

namespace halfshade {
namespace {

constexpr int kAlbedoSamples = 128;  // a side
constexpr int kFitSamples = 32;
constexpr int kMaxSteps = 400;

// Centres of n x n cells of the unit square.
template <typename Visit>
void ForEachCell(int n, Visit visit) {
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) visit(glm::dvec2((x + 0.5) / n, (y + 0.5) / n));
  }
}

// A transformed cosine: matrix, inverse, and its density.
struct Cosine {
  glm::dmat3 m, inverse;
  double determinant_of_inverse = 1;
  double share_above = 1;

  // `axis`: the lobe's mean direction, in the plane y = 0.
  Cosine(const LtcLobe& lobe, const glm::dvec3& axis) {
    const double width_x = std::exp(lobe[0]);
    const double width_y = std::exp(lobe[1]);
    const glm::dmat3 frame(glm::dvec3(axis.z, 0, -axis.x), glm::dvec3(0, 1, 0), axis);
    m = frame * glm::dmat3(width_x, 0, 0, 0, width_y, 0, lobe[2] * width_x, 0, 1);
    inverse = glm::inverse(m);
    determinant_of_inverse = std::abs(glm::determinant(inverse));
    share_above = LtcShareAbove(Entry());
  }

  LtcEntry Entry() const {
    const double scale = 1 / inverse[1][1];
    LtcEntry entry;
    entry.m11 = inverse[0][0] * scale;
    entry.m13 = inverse[2][0] * scale;
    entry.m31 = inverse[0][2] * scale;
    entry.m33 = inverse[2][2] * scale;
    return entry;
  }

  glm::dvec3 Sample(const glm::dvec2& unit) const {
    const double radius = std::sqrt(unit.x);
    const double angle = 2 * M_PI * unit.y;
    return glm::normalize(m * glm::dvec3(radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1 - unit.x)));
  }

  // Over the whole sphere.
  double Density(const glm::dvec3& light) const {
    const glm::dvec3 original = inverse * light;
    const double length2 = glm::dot(original, original);
    return std::max(0.0, original.z) * determinant_of_inverse / (M_PI * length2 * length2);
  }
};

class Objective {
 public:
  Objective(double alpha, double cosine) : alpha_(alpha), view_(std::sqrt(1 - cosine * cosine), 0, cosine) {
    glm::dvec3 mean(0);
    ForEachCell(kAlbedoSamples, [&](const glm::dvec2& unit) {
      const GgxSample sample = SampleGgx(view_, alpha_, unit);
      albedo_ += sample.weight;
      grazing_ += sample.weight * sample.fresnel_share;
      mean += sample.weight * sample.light;
    });
    albedo_ /= kAlbedoSamples * kAlbedoSamples;
    grazing_ /= kAlbedoSamples * kAlbedoSamples;
    axis_ = cosine == 1 ? glm::dvec3(0, 0, 1) : glm::normalize(glm::dvec3(mean.x, 0, mean.z));
    ForEachCell(kFitSamples, [&](const glm::dvec2& unit) {
      const GgxSample sample = SampleGgx(view_, alpha_, unit);
      if (sample.weight > 0) samples_.push_back(sample);
    });
  }

  double operator()(const LtcLobe& lobe) const {
    const Cosine cosine(lobe, axis_);
    double sum = 0;
    for (const GgxSample& sample : samples_) {
      sum += Term(sample.light, sample.weight * sample.density, sample.density, cosine);
    }
    ForEachCell(kFitSamples, [&](const glm::dvec2& unit) {
      const glm::dvec3 light = cosine.Sample(unit);
      if (light.z <= 0) return;
      sum += Term(light, GgxTimesCosine(view_, light, alpha_), GgxDensity(view_, light, alpha_), cosine);
    });
    return sum;
  }

  LtcEntry Entry(const LtcLobe& lobe) const {
    LtcEntry entry = Cosine(lobe, axis_).Entry();
    entry.albedo = albedo_;
    entry.grazing = grazing_;
    return entry;
  }

 private:
  double Term(const glm::dvec3& light, double ggx, double ggx_density, const Cosine& cosine) const {
    const double density = cosine.Density(light);
    const double difference = std::abs(ggx / albedo_ - density / cosine.share_above);
    return difference * difference * difference / (ggx_density + density);
  }

  double alpha_;
  glm::dvec3 view_;
  double albedo_ = 0, grazing_ = 0;
  glm::dvec3 axis_{0, 0, 1};
  std::vector<GgxSample> samples_;
};

// Nelder and Mead 1965, with the usual factors.
template <size_t N>
std::array<double, N> Minimize(const std::array<double, N>& start,
                               const std::function<double(const std::array<double, N>&)>& objective) {
  using Point = std::array<double, N>;
  struct Vertex {
    double value;
    Point point;
  };
  std::vector<Vertex> simplex = {{objective(start), start}};
  for (size_t i = 0; i < N; ++i) {
    Point point = start;
    point[i] += 0.1;
    simplex.push_back({objective(point), point});
  }
  const auto by_value = [](const Vertex& a, const Vertex& b) { return a.value < b.value; };
  for (int step = 0; step < kMaxSteps; ++step) {
    std::stable_sort(simplex.begin(), simplex.end(), by_value);
    if (simplex[N].value - simplex[0].value <= 1e-12 * simplex[0].value) break;
    Point center{};
    for (size_t v = 0; v < N; ++v) {
      for (size_t i = 0; i < N; ++i) center[i] += simplex[v].point[i] / N;
    }
    const auto along = [&](double t) {  // 1: the worst vertex, -1: its reflection
      Point point;
      for (size_t i = 0; i < N; ++i) point[i] = center[i] + t * (simplex[N].point[i] - center[i]);
      return Vertex{objective(point), point};
    };
    const Vertex reflected = along(-1);
    if (reflected.value < simplex[0].value) {
      simplex[N] = std::min(reflected, along(-2), by_value);
    } else if (reflected.value < simplex[N - 1].value) {
      simplex[N] = reflected;
    } else if (const Vertex contracted = along(reflected.value < simplex[N].value ? -0.5 : 0.5);
               contracted.value < std::min(reflected.value, simplex[N].value)) {
      simplex[N] = contracted;
    } else {
      for (size_t v = 1; v <= N; ++v) {
        for (size_t i = 0; i < N; ++i) simplex[v].point[i] = (simplex[0].point[i] + simplex[v].point[i]) / 2;
        simplex[v].value = objective(simplex[v].point);
      }
    }
  }
  return std::min_element(simplex.begin(), simplex.end(), by_value)->point;
}

}  // namespace

LtcLobe PlainLobe(double roughness) { return {2 * std::log(roughness), 2 * std::log(roughness), 0}; }

LtcFit FitLtc(double roughness, double cosine, const LtcLobe& start) {
  const Objective objective(roughness * roughness, cosine);
  LtcFit fit;
  if (cosine == 1) {  // round
    const auto width = Minimize<1>({start[0]}, [&](const std::array<double, 1>& w) {
      return objective({w[0], w[0], 0});
    });
    fit.lobe = {width[0], width[0], 0};
  } else {
    fit.lobe = Minimize<3>(start, objective);
  }
  fit.entry = objective.Entry(fit.lobe);
  return fit;
}

}  // namespace halfshade
