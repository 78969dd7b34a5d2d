// The events of one sample's map: where a ray's view of the sample is hidden and seen again. Two exact forms that find
// the same events in another order; both ask SamplePath and the map, and nothing else.
//
// With d falling along a ray: in a texel of depth T the sample is hidden where d < T. So it becomes hidden
// - at T where the ray is inside the texel at that depth (kTop): a surface;
// - at the border of texels A and B, entered in this order at depth b, where T_A <= b < T_B (kWall), and
// is seen again where T_B <= b < T_A (kWall). Nothing else happens.
// Texels outside of the map are empty (T = 0). Source: St-Amour et al. 2005, Algorithm 1 and Fig. 4.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/shadow/pdsm/pdsm_grid.h"

namespace halfshade::pdsm {

enum class EventKind : uint8_t { kTop, kWall };

struct Event {
  glm::ivec2 ray{0};
  float depth = 0;
  bool is_entry = true;  // becomes hidden
  EventKind kind = EventKind::kTop;
  glm::ivec2 texel{0};  // the one whose top it is, or that is entered
  glm::ivec2 move{0};   // from the texel that is left (kWall)
};

// Algorithm 1: every ray of row `row` of the PDSM over every texel that it meets. emit(const Event&).
template <typename Emit>
void TraverseRow(const Grid& grid, const SampleMap& map, const SamplePath& path, int row, const Emit& emit) {
  const auto depth_of = [&](const glm::ivec2& texel) {
    const bool is_inside = texel.x >= 0 && texel.y >= 0 && texel.x < grid.map_size && texel.y < grid.map_size;
    return is_inside ? map.depths[size_t(texel.y) * grid.map_size + texel.x] : 0.0f;
  };
  for (int column = 0; column < grid.size; ++column) {
    const glm::ivec2 ray(column, row);
    float before = 0;
    for (size_t q = 0; q < path.steps.size(); ++q) {
      const SamplePath::Step& step = path.steps[q];
      const float leaves_at = q + 1 < path.steps.size() ? path.steps[q + 1].depth : 0;
      const glm::ivec2 texel = ray * grid.map_texels + step.cell;
      const float depth = depth_of(texel);
      if (q > 0 && (before > step.depth) != (depth > step.depth)) {
        emit(Event{ray, step.depth, depth > step.depth, EventKind::kWall, texel, step.cell - path.steps[q - 1].cell});
      }
      if (depth > leaves_at && depth <= step.depth)
        emit(Event{ray, depth, true, EventKind::kTop, texel, glm::ivec2(0)});
      before = depth;
    }
  }
}

// Event scatter, in two parts: the step at which each texel's depth lies, then what the texels of a row send to rays.
// A texel's top goes to the one ray that is over it at that step. A border of texels of other steps goes to a ray for
// each step between them that crosses such a border.
class TexelSteps {
 public:
  TexelSteps(const Grid& grid, const SampleMap& map, const SamplePath& path);

  // The texels of map row `row` (0 to map_size, the empty row after the last included), and the borders that lie before
  // them (in u and in v).
  template <typename Emit>
  void ScatterRow(int row, const Emit& emit) const;

 private:
  // Steps that move by one vector: all that cross one kind of border.
  struct Direction {
    glm::ivec2 move{0};
    std::vector<int> steps;        // rising
    std::vector<int> count_up_to;  // [step]: how many of them are at or before it
  };
  // Step of a texel; the last + 1 for an empty one and outside.
  int At(int x, int y) const {
    const bool is_inside = x >= 0 && y >= 0 && x < grid_.map_size && y < grid_.map_size;
    return is_inside ? steps_[size_t(y) * grid_.map_size + x] : none_;
  }
  template <typename Emit>
  void Send(const glm::ivec2& texel, int step, float depth, bool is_entry, EventKind kind, const glm::ivec2& move,
            const Emit& emit) const {
    const glm::ivec2 place = texel - path_.steps[step].cell;
    if (place.x < 0 || place.y < 0) return;
    const glm::ivec2 ray = place / grid_.map_texels;
    if (ray.x >= grid_.size || ray.y >= grid_.size || ray * grid_.map_texels != place) return;
    emit(Event{ray, depth, is_entry, kind, texel, move});
  }
  // The border that is crossed from `from` into `to`.
  template <typename Emit>
  void SendBorder(const Direction& direction, int from, int to, const glm::ivec2& entered, const Emit& emit) const {
    // Hidden at a crossing of step q if the texel's depth > its depth: step of the texel < q.
    const int first = direction.count_up_to[std::min(from, to)];
    const int last = direction.count_up_to[std::max(from, to)];
    for (int i = first; i < last; ++i) {
      const int step = direction.steps[i];
      Send(entered, step, path_.steps[step].depth, to < from, EventKind::kWall, direction.move, emit);
    }
  }

  const Grid& grid_;
  const SampleMap& map_;
  const SamplePath& path_;
  int none_ = 0;
  std::vector<uint16_t> steps_;  // [map_size][map_size]
  std::vector<Direction> directions_;
};

template <typename Emit>
void TexelSteps::ScatterRow(int row, const Emit& emit) const {
  for (int x = 0; x < grid_.map_size && row < grid_.map_size; ++x) {
    const int step = At(x, row);
    if (step < none_) {
      Send({x, row}, step, map_.depths[size_t(row) * grid_.map_size + x], true, EventKind::kTop, glm::ivec2(0), emit);
    }
  }
  for (const Direction& direction : directions_) {
    // Borders between this row and what lies before it in v, or within it.
    const int enters_row = direction.move.y >= 0 ? row : row - 1;
    const int leaves_row = enters_row - direction.move.y;
    if (direction.move.y == 0 && row == grid_.map_size) continue;
    // Borders in u: from the one before the first texel to the one after the last.
    for (int x = -1; x <= grid_.map_size; ++x) {
      const int to = At(x, enters_row);
      const int from = At(x - direction.move.x, leaves_row);
      if (to != from) SendBorder(direction, from, to, {x, enters_row}, emit);
    }
  }
}

}  // namespace halfshade::pdsm
