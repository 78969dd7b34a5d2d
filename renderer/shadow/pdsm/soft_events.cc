#include "renderer/shadow/pdsm/soft_events.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>

#include "renderer/shadow/pdsm/events.h"
#include "renderer/status.h"

namespace halfshade::pdsm {
namespace {

constexpr int kRowsPerTask = 16;
constexpr int kReach = 2;  // texels around a crossing that tell the edge's normal

// Share of a stratum with coordinates across an edge above l: its projection is taken to be even.
double ShareAbove(double low, double high, double l) {
  return high > low ? std::clamp((high - l) / (high - low), 0.0, 1.0) : double(l <= high);
}

// The edge's normal where a ray crosses it: from where texels hide the ray to where they do not. `border`: the way over
// the crossed border, where the texels around it do not tell.
glm::dvec2 NormalAt(const Grid& grid, const SampleMap& map, const glm::ivec2& texel, const glm::ivec2& move,
                    float depth) {
  const glm::dvec2 middle = glm::dvec2(texel) - 0.5 * glm::dvec2(move);
  const glm::ivec2 low = glm::max(glm::min(texel, texel - move) - (kReach - 1), glm::ivec2(0));
  const glm::ivec2 high = glm::min(glm::max(texel, texel - move) + (kReach - 1), glm::ivec2(grid.map_size - 1));
  glm::dvec2 sum(0);
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) {
      const float other = map.depths[size_t(y) * grid.map_size + x];
      // An empty texel hides nothing, at depths below 0 too.
      if (other > 0 && other > depth) sum += glm::dvec2(x, y) - middle;
    }
  }
  // Slopes, not texels: texels need not be square.
  sum = sum / grid.MapTexel();
  const double length = glm::length(sum);
  return length > 0 ? sum / length : glm::normalize(glm::dvec2(move) / grid.MapTexel());
}

}  // namespace

std::vector<Stratum> Strata(const glm::dvec2& half_edges, int k) {
  glm::ivec2 cells(1);
  glm::dvec2 half = half_edges;
  while (cells.x * cells.y < k) {
    const int axis = half.x >= half.y ? 0 : 1;
    half[axis] /= 2;
    cells[axis] *= 2;
  }
  std::vector<Stratum> strata;
  for (int y = 0; y < cells.y; ++y) {
    for (int x = 0; x < cells.x; ++x) {
      strata.push_back({(glm::dvec2(x, y) * 2.0 + 1.0) * half - half_edges, half});
    }
  }
  return strata;
}

void AppendRamp(const Ramp& ramp, uint32_t column, std::vector<SlopeEvent>* events) {
  // On the side of the light that the edge sweeps, l > 0: as depth falls from the edge's own, l falls to `end`.
  const bool is_positive = ramp.across >= 0;
  const double low = std::max(0.0, is_positive ? ramp.low : -ramp.high);
  const double high = is_positive ? ramp.high : -ramp.low;
  const double offset = std::abs(ramp.across) * (ramp.occluder_depth - ramp.depth);
  const auto depth_at = [&](double l) { return l > 0 ? ramp.occluder_depth - offset / l : -1.0; };
  const double end = std::max(low, offset / (ramp.occluder_depth - ramp.behind_depth));
  const double full_low = is_positive ? ramp.low : -ramp.high;
  if (high <= end) {
    // The sample's own step: of a stratum of no extent across the edge, or where the surface behind comes first.
    if ((high <= full_low || ramp.behind_depth > 0) && ramp.depth > 0)
      events->push_back({column, float(ramp.depth), 0, float(ramp.sign)});
    return;
  }
  double before_depth = depth_at(high), before = 0, slope = 0;
  for (int i = 1; i <= kRampPieces; ++i) {
    // Even in sqrt(l), so that straight pieces fit the hyperbola l(depth) about as well everywhere.
    const double root = std::sqrt(high) + (std::sqrt(end) - std::sqrt(high)) * i / kRampPieces;
    const double l = root * root;
    const double depth = std::max(ramp.behind_depth, l > 0 ? depth_at(l) : 0);
    const double share = ShareAbove(full_low, high, l) * ramp.sign;
    const double run = before_depth - depth;
    // What float depths do not tell apart is a step.
    if (float(before_depth) == float(depth)) {
      events->push_back({column, float(depth), 0, float(share - before)});
    } else {
      const double next = (share - before) / run;
      events->push_back({column, float(before_depth), float(next - slope), 0});
      slope = next;
    }
    before = share;
    before_depth = depth;
  }
  if (before_depth <= 0) return;
  const double rest = ramp.behind_depth > 0 ? ramp.sign - before : 0;
  events->push_back({column, float(before_depth), float(-slope), float(rest)});
}

// [row of the PDSM] of each thread.
struct SoftEventBuilder::Rows {
  using Lists = std::vector<std::vector<SlopeEvent>>;
  explicit Rows(int size) : lists(Lists(size)) {}
  tbb::enumerable_thread_specific<Lists> lists;
  std::atomic<uint64_t> events{0};
};

SoftEventBuilder::SoftEventBuilder(const Grid& grid, uint64_t max_events)
    : grid_(grid), max_events_(max_events), rows_(std::make_unique<Rows>(grid.size)) {}
SoftEventBuilder::~SoftEventBuilder() = default;

absl::Status SoftEventBuilder::Add(const SampleMap& map, const Stratum& stratum) {
  ++maps_;
  const SamplePath path = MakePath(grid_, map.point, map.corner, kFarDepth);
  const TexelSteps steps(grid_, map, path);
  const auto depth_of = [&](const glm::ivec2& texel) {
    const bool is_inside = texel.x >= 0 && texel.y >= 0 && texel.x < grid_.map_size && texel.y < grid_.map_size;
    return is_inside ? map.depths[size_t(texel.y) * grid_.map_size + texel.x] : 0.0f;
  };
  tbb::parallel_for(tbb::blocked_range<int>(0, grid_.map_size + 1, kRowsPerTask),
                    [&](const tbb::blocked_range<int>& range) {
                      Rows::Lists& lists = rows_->lists.local();
                      uint64_t count = 0;
                      const auto emit = [&](const Event& event) {
                        std::vector<SlopeEvent>& list = lists[event.ray.y];
                        const size_t before = list.size();
                        if (event.kind == EventKind::kTop) {
                          list.push_back({uint32_t(event.ray.x), event.depth, 0, 1});
                        } else {
                          const glm::dvec2 normal = NormalAt(grid_, map, event.texel, event.move, event.depth);
                          const double reach = glm::dot(glm::abs(normal), stratum.half);
                          const double middle = glm::dot(normal, stratum.middle);
                          const float entered = depth_of(event.texel), left = depth_of(event.texel - event.move);
                          // Of a sample nearer to l = 0 than that, an edge whose normal is not quite known would be met
                          // anywhere.
                          const double across = glm::dot(normal, map.point);
                          const double least = 0.5 * reach;
                          AppendRamp({.occluder_depth = std::max(entered, left),
                                      .depth = event.depth,
                                      .behind_depth = std::min(entered, left),
                                      .across = std::copysign(std::max(std::abs(across), least), across),
                                      .low = middle - reach,
                                      .high = middle + reach,
                                      .sign = event.is_entry ? 1.0 : -1.0},
                                     uint32_t(event.ray.x), &list);
                        }
                        count += list.size() - before;
                      };
                      for (int row = range.begin(); row < range.end(); ++row) steps.ScatterRow(row, emit);
                      rows_->events += count;
                    });
  if (rows_->events > max_events_) return TooManyEvents(rows_->events, maps_, max_events_);
  return absl::OkStatus();
}

namespace {

// Events of one ray, sorted by depth, nearest to the light first -> the polyline that they sum up to.
void MakePolyline(const std::vector<SlopeEvent>& events, size_t begin, size_t end, int maps,
                  std::vector<Vertex>* vertices) {
  vertices->clear();
  double value = 0, slope = 0;
  float depth = 0;
  const auto add = [&](float at, double sum) { vertices->push_back({at, float(std::clamp(sum / maps, 0.0, 1.0))}); };
  for (size_t i = begin; i < end;) {
    if (i > begin) value += slope * (double(depth) - events[i].depth);
    depth = events[i].depth;
    double step = 0;
    for (; i < end && events[i].depth == depth; ++i) {
      slope += events[i].slope;
      step += events[i].step;
    }
    add(depth, value);
    if (step == 0) continue;
    value += step;
    add(depth, value);
  }
  if (!vertices->empty() && depth > 0) add(0, value + slope * depth);
}

}  // namespace

absl::StatusOr<EventBuilder::Result> SoftEventBuilder::Finish(const Finishing& finishing) {
  std::atomic<uint32_t> most{0};
  const auto make_row = [&](int row, FunctionRow* out) {
    std::vector<SlopeEvent> events;
    for (Rows::Lists& lists : rows_->lists) {
      events.insert(events.end(), lists[row].begin(), lists[row].end());
      lists[row] = {};
    }
    // In an order of their own: threads leave no trace.
    std::sort(events.begin(), events.end(), [](const SlopeEvent& a, const SlopeEvent& b) {
      if (a.column != b.column) return a.column < b.column;
      if (a.depth != b.depth) return a.depth > b.depth;
      return a.slope != b.slope ? a.slope < b.slope : a.step < b.step;
    });
    std::vector<Vertex> polyline;
    size_t begin = 0;
    for (int x = 0; x < grid_.size; ++x) {
      size_t end = begin;
      while (end < events.size() && events[end].column == uint32_t(x)) ++end;
      uint32_t known = most;
      while (known < end - begin && !most.compare_exchange_weak(known, uint32_t(end - begin))) {
      }
      MakePolyline(events, begin, end, maps_, &polyline);
      out->Add(polyline, finishing.eps);
      begin = end;
    }
  };
  EventBuilder::Result result;
  ASSIGN_OR_RETURN(result.functions, FinishRows(grid_.size, finishing.stop, make_row));
  result.raw.mean = double(rows_->events) / double(grid_.RayCount());
  result.raw.most = most;
  rows_ = std::make_unique<Rows>(grid_.size);
  maps_ = 0;
  return result;
}

}  // namespace halfshade::pdsm
