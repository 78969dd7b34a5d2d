// One map seen from a light's centre, a pyramid of its depths, and filtering over the light's image in it: PCSS, and
// what SSSM does where rows cannot be shared (shaders/light/filter_window.frag).
//
// Windows are exact in light perspective space (Buades et al. 2015, eq. 1 divided by the receiver's depth); the pyramid
// proves receivers lit or dark, to the bits that filtering would give. Where occluders reach beyond the map and a
// window leaves it, the light's centre decides alone, from maps of all sides: a hard shadow, never silently lit.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "renderer/gl/draw_context.h"
#include "renderer/gl/handles.h"
#include "renderer/gl/texture.h"
#include "renderer/light/light_data.h"
#include "renderer/light/occluders_on_context.h"
#include "renderer/light/receivers.h"
#include "renderer/light/sample_maps.h"
#include "renderer/light/tiles.h"
#include "renderer/request.h"

namespace halfshade {

// Taps a side of both windows.
struct WindowTaps {
  int blocker = 7;
  int filter = 15;
  FilterWeights weights = FilterWeights::kMean;
};

// "MEAN", "GAUSSIAN": enum values of the wire, for reports.
const char* WeightsName(FilterWeights weights);

class CenterMap : public LightData {
 public:
  // `cell`: `light`, in whose frame the occluders are, or a part of it in the same plane.
  static absl::StatusOr<std::unique_ptr<CenterMap>> Create(const DrawContext& draw,
                                                           std::shared_ptr<const OccludersOnContext> occluders,
                                                           const AreaLight& light, const AreaLight& cell, int map_size);

  // Hidden fraction of the part of the light above each receiver's plane.
  struct Filtered {
    gl::Texture hidden;    // R32F [height][width]
    gl::Texture blockers;  // RG32F: w of the average blocker less the receiver's, 1 where there is one; or empty
    uint64_t tiles_drawn;  // of 16 x 16 receivers
  };
  // `skips`: tiles that the pyramid decides are not drawn. Blockers come where `receivers` want them.
  absl::StatusOr<Filtered> Filter(const DrawContext& draw, const Receivers& receivers, const WindowTaps& taps,
                                  bool skips) const;

  // For passes of a method's own: sets and binds all that light/map_receiver.glsl and light/filter_rows.glsl read, and
  // HiddenCenter for a pass that reads it.
  void SetUniforms(const DrawContext& draw, gl::Program& program, const Receivers& receivers, const WindowTaps& taps,
                   const gl::Texture* hidden_center = nullptr) const;
  // Whether the centre is hidden, for receivers whose window leaves the map; empty where all occluders are in it.
  absl::StatusOr<gl::Texture> HiddenCenter(const DrawContext& draw, const Receivers& receivers) const;
  static constexpr int kFirstFreeUnit = kPlanesUnit + 3;

  const AreaLight& cell() const { return cell_; }
  uint64_t SizeBytes() const override { return maps_->SizeBytes() + pyramid_bytes_; }
  uint64_t MapsDrawn() const override { return maps_->MapsDrawn(); }

  // What both hold, of one map in front.
  static uint64_t PredictedBytes(int map_size);

 private:
  AreaLight cell_;
  std::unique_ptr<SampleMaps> maps_;  // from the centre, all sides
  gl::Buffer ranges_;
  std::vector<glm::vec4> levels_;
  uint64_t pyramid_bytes_ = 0;
};

// The proofs that a pass has written (0 lit, 1 dark, -1 unknown), [height][width]. Waits for the drawing.
absl::StatusOr<std::vector<float>> ReadProofs(const gl::Texture& proofs);

// The tiles that hold a proof for which `is_wanted(proof)`.
template <typename Predicate>
TileList ListProofs(const std::vector<float>& proofs, int width, int height, Predicate is_wanted) {
  std::vector<bool> wanted(proofs.size());
  for (size_t i = 0; i < proofs.size(); ++i) wanted[i] = is_wanted(proofs[i]);
  return ListTiles(width, height, wanted);
}

}  // namespace halfshade
