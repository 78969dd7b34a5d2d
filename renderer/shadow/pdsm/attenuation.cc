#include "renderer/shadow/pdsm/attenuation.h"

#include <algorithm>
#include <cassert>
#include <functional>
#include <limits>

namespace halfshade::pdsm {
namespace {

// All lines through an origin that stay within eps of the points so far.
class SlopeWindow {
 public:
  SlopeWindow(const Vertex& origin, float eps) : origin_(origin), eps_(eps) {}

  // False: no such line reaches the point too, and the window stays as it is. Needs point.depth < origin's.
  bool Add(const Vertex& point) {
    const double run = double(origin_.depth) - point.depth;
    // Light and umbra stay exact.
    const double eps = point.value == 0 || point.value == 1 ? 0 : eps_;
    const double low = std::max(low_, (std::max(0.0, double(point.value) - eps) - origin_.value) / run);
    const double high = std::min(high_, (std::min(1.0, double(point.value) + eps) - origin_.value) / run);
    if (low > high) return false;
    low_ = low;
    high_ = high;
    last_ = point;
    return true;
  }
  const Vertex& origin() const { return origin_; }
  // Where the line ends, at the last point's depth, that comes nearest to it.
  Vertex End() const {
    const double run = double(origin_.depth) - last_.depth;
    const double value = std::clamp(double(last_.value), origin_.value + run * low_, origin_.value + run * high_);
    return {last_.depth, float(value)};
  }

 private:
  Vertex origin_;
  double eps_;
  double low_ = -std::numeric_limits<double>::infinity();
  double high_ = std::numeric_limits<double>::infinity();
  Vertex last_;
};

}  // namespace

float Evaluate(std::span<const Vertex> function, float depth) {
  // The first vertex at or beyond the depth.
  const auto next = std::partition_point(function.begin(), function.end(),
                                         [&](const Vertex& vertex) { return vertex.depth > depth; });
  if (next == function.begin()) return 0;
  const Vertex& before = next[-1];
  if (next == function.end()) return before.value;
  const float along = (before.depth - depth) / (before.depth - next->depth);
  return before.value + (next->value - before.value) * along;
}

namespace {

// The value just beyond a depth: of a jump there, the one farther from the light.
float EvaluateBeyond(std::span<const Vertex> function, float depth) {
  const auto next = std::partition_point(function.begin(), function.end(),
                                         [&](const Vertex& vertex) { return vertex.depth >= depth; });
  return next != function.begin() && next[-1].depth == depth ? next[-1].value : Evaluate(function, depth);
}

}  // namespace

void Compress(std::span<const Vertex> function, float eps, std::vector<Vertex>* out) {
  // Slopes and ends are rounded to floats: an ulp of 1 is kept back for that.
  const float bound = std::max(0.0f, eps - std::numeric_limits<float>::epsilon());
  const bool is_zero =
      std::all_of(function.begin(), function.end(), [&](const Vertex& vertex) { return vertex.value <= bound; });
  if (is_zero) return;
  SlopeWindow window({function[0].depth, 0}, bound);
  out->push_back(window.origin());
  bool is_open = false;  // the window has points
  const auto restart = [&](const Vertex& origin) {
    out->push_back(origin);
    window = SlopeWindow(origin, bound);
    is_open = false;
  };
  const auto add = [&](const Vertex& point) {
    if (point.depth < window.origin().depth && window.Add(point)) {
      is_open = true;
      return;
    }
    if (is_open) restart(window.End());
    // From a new origin, which is within the bound of the function on its near side.
    if (point.depth < window.origin().depth && window.Add(point)) {
      is_open = true;
      return;
    }
    // A jump at the origin's own depth.
    const float most = point.value == 0 || point.value == 1 ? 0 : bound;
    if (std::abs(point.value - window.origin().value) > most) restart(point);
  };
  for (const Vertex& point : function) add(point);
  // To the far end.
  const Vertex& last = function.back();
  if (last.depth > 0) add({0, last.value});
  if (is_open && window.End().value != window.origin().value) out->push_back(window.End());
}

void FunctionRow::Add(std::span<const Vertex> exact, float eps) {
  const size_t first = vertices.size();
  if (!exact.empty()) Compress(exact, eps, &vertices);
  counts.push_back(uint32_t(vertices.size() - first));
}

AttenuationFunctions JoinRows(const std::vector<FunctionRow>& rows) {
  AttenuationFunctions functions;
  functions.size = int(rows.size());
  functions.first.reserve(rows.size() * rows.size() + 1);
  functions.first.push_back(0);
  for (const FunctionRow& row : rows) {
    for (const uint32_t count : row.counts) functions.first.push_back(functions.first.back() + count);
  }
  functions.vertices.reserve(functions.first.back());
  for (const FunctionRow& row : rows) {
    functions.vertices.insert(functions.vertices.end(), row.vertices.begin(), row.vertices.end());
  }
  return functions;
}

AttenuationFunctions Add(const AttenuationFunctions& a, const AttenuationFunctions& b) {
  assert(a.size == b.size);
  AttenuationFunctions sum;
  sum.size = a.size;
  sum.first.push_back(0);
  std::vector<float> depths;
  for (size_t ray = 0; ray + 1 < a.first.size(); ++ray) {
    const std::span<const Vertex> of_a = a.Function(ray), of_b = b.Function(ray);
    depths.clear();
    for (const auto& function : {of_a, of_b}) {
      for (const Vertex& vertex : function) depths.push_back(vertex.depth);
    }
    std::sort(depths.begin(), depths.end(), std::greater<float>());
    depths.erase(std::unique(depths.begin(), depths.end()), depths.end());
    Vertex before;  // not clamped
    const auto add = [&](float depth, float value) {
      // Where a slope reaches 1.
      if ((before.value - 1) * (value - 1) < 0 && depth < before.depth) {
        const float along = (1 - before.value) / (value - before.value);
        sum.vertices.push_back({before.depth + (depth - before.depth) * along, 1});
      }
      before = {depth, value};
      sum.vertices.push_back({depth, std::min(value, 1.0f)});
    };
    for (const float depth : depths) {
      const float near = Evaluate(of_a, depth) + Evaluate(of_b, depth);
      const float far = EvaluateBeyond(of_a, depth) + EvaluateBeyond(of_b, depth);
      add(depth, near);
      if (far != near) add(depth, far);
    }
    sum.first.push_back(uint32_t(sum.vertices.size()));
  }
  return sum;
}

FunctionCounts CountVertices(const AttenuationFunctions& functions) {
  FunctionCounts counts;
  const size_t rays = size_t(functions.size) * functions.size;
  for (size_t ray = 0; ray < rays; ++ray) {
    counts.most = std::max(counts.most, functions.first[ray + 1] - functions.first[ray]);
  }
  counts.mean = rays == 0 ? 0 : double(functions.vertices.size()) / double(rays);
  return counts;
}

}  // namespace halfshade::pdsm
