// Attenuation at planes of constant depth: which samples are hidden from each ray there, counted.
//
// At one depth all rays of a PDSM stand over a map's texels at the same offset, so that a slice of a map is the map
// itself shifted and compared with that depth: 64 rays an AVX-512 instruction. Maps come one after the other; what is
// kept is the counts. Equal to the exact functions (event_builder.h) at every slice; between slices values are
// interpolated.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/shadow/pdsm/attenuation.h"
#include "renderer/shadow/pdsm/pdsm_grid.h"

namespace halfshade::pdsm {

// Counts of hidden samples at slices; value = count / maps.
struct SliceVolume {
  int size = 0;
  int maps = 0;
  std::vector<float> depths;     // of the slices, from 0 up to the nearest to the light
  std::vector<uint16_t> counts;  // [slice][row][column]
  uint64_t SizeBytes() const { return counts.size() * sizeof(uint16_t) + depths.size() * sizeof(float); }
};

// `count` depths from 0 to 1, evenly spaced.
std::vector<float> EvenSlices(int count);

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

// The polylines through the slices, compressed.
AttenuationFunctions FunctionsOfSlices(const SliceVolume& volume, float eps);
// Functions at the depths of slices, as a volume of `maps` samples (values rounded to 1 / maps).
SliceVolume SlicesOfFunctions(const AttenuationFunctions& functions, std::vector<float> depths, int maps);

}  // namespace halfshade::pdsm
