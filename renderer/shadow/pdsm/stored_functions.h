// Attenuation functions as bytes, for a store on disk or another machine.
//
// "halfshade pdsm" and a version; a checksum of all that follows; the grid; then the functions' lengths and vertices,
// or the slices' counts: little-endian, as they stand in memory. What is read may be anything: it is refused unless the
// checksum and every number that a lookup relies on fit. Pure; no GL.
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "renderer/shadow/pdsm/attenuation.h"
#include "renderer/shadow/pdsm/pdsm_grid.h"
#include "renderer/shadow/pdsm/slice_builder.h"

namespace halfshade::pdsm {

struct StoredFunctions {
  Grid grid;
  std::variant<AttenuationFunctions, SliceVolume> functions;
};

std::string Store(const StoredFunctions& stored);
// Empty: torn, changed, of another version, or not ours.
std::optional<StoredFunctions> Restore(const std::string& bytes);

}  // namespace halfshade::pdsm
