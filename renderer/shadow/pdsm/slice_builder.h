// Attenuation at planes of constant depth: which samples are hidden from each ray there, counted.
//
// At one depth all rays of a PDSM stand over a map's texels at the same offset, so that a slice of a map is the map
// itself shifted and compared with that depth: 64 rays an AVX-512 instruction. Maps come one after the other; what is
// kept is the counts. Equal to the exact functions (event_builder.h) at every slice. Between two
// slices a function is a straight line from the nearer one to what is hidden at the farther one by surfaces nearer than
// both; those between count from the farther slice on: else every surface would shadow itself up to a slice away.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/shadow/pdsm/pdsm_grid.h"

namespace halfshade::pdsm {

// Hidden samples at slices, and those hidden by what is nearer than the next slice; value = count / maps.
struct SliceCounts {
  uint16_t hidden = 0;
  uint16_t hidden_from_beyond = 0;  // by a surface at or before the next slice: <= hidden
  bool operator==(const SliceCounts&) const = default;
};
struct SliceVolume {
  int size = 0;
  int maps = 0;
  std::vector<float> depths;        // of the slices, from 0 up to the nearest to the light
  std::vector<SliceCounts> counts;  // [slice][row][column]
  uint64_t SizeBytes() const { return counts.size() * sizeof(SliceCounts) + depths.size() * sizeof(float); }
};

// Depths of slices: evenly spaced from the farthest occluder's on, where a shadow that falls on what is less than a
// slice behind its occluder is missed. Behind all occluders penumbrae alone change, as 1 over the way from the
// occluder: a few slices do, spaced by squares, the densest next to the occluders.
struct SliceSpacing {
  int count = 2;
  int behind = 0;            // slices before the one at occluders_from, 1 to count - 2
  float occluders_from = 0;  // in (0, 1)
  std::vector<float> Depths() const;
};
// Of count >= 3 slices.
SliceSpacing SpaceSlices(int count, double farthest_occluder_depth);

class SliceBuilder {
 public:
  // 1 to 255 slices, depths rising from 0.
  SliceBuilder(const Grid& grid, std::vector<float> depths);
  // Runs on TBB's threads; the counts do not depend on them.
  void Add(const SampleMap& map);
  SliceVolume Finish();

 private:
  // How many slices each texel of a map hides, in planes of texels that one set of rays sees (a plane for every
  // offset within a PDSM texel), rows padded with zeros.
  struct Buckets {
    std::vector<uint8_t> values;
    std::vector<glm::ivec2> cells;  // [slice]: the texel under ray (0, 0)
  };
  void AddPending();

  const Grid grid_;
  SliceVolume volume_;
  int plane_side_ = 0;
  int stride_ = 0;
  std::vector<Buckets> pending_;
};

}  // namespace halfshade::pdsm
