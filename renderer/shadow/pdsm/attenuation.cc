#include "renderer/shadow/pdsm/attenuation.h"

#include <algorithm>
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

AttenuationFunctions JoinRows(int size, const std::vector<uint32_t>& counts,
                              const std::vector<std::vector<Vertex>>& rows) {
  AttenuationFunctions functions;
  functions.size = size;
  functions.first.resize(counts.size() + 1);
  for (size_t ray = 0; ray < counts.size(); ++ray) functions.first[ray + 1] = functions.first[ray] + counts[ray];
  functions.vertices.reserve(functions.first.back());
  for (const std::vector<Vertex>& row : rows) {
    functions.vertices.insert(functions.vertices.end(), row.begin(), row.end());
  }
  return functions;
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
