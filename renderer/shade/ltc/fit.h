// Fits one entry of the table. Pure and deterministic: the same arguments give the same entry.
#pragma once

#include <array>

#include "renderer/shade/ltc/ltc_table.h"

namespace halfshade {

// The lobe as three numbers: logarithms of its widths in and across the plane of view, and its skew in units of the
// first width.
using LtcLobe = std::array<double, 3>;

struct LtcFit {
  LtcEntry entry;
  LtcLobe lobe;
};

// `start` is the lobe of a neighbour. Nelder-Mead on the cubed difference between GGX and the transformed cosine, both
// of volume 1 above the surface, integrated over 2 x 32 x 32 directions that the two draw themselves.
// roughness in [kMinLtcRoughness, 1], cosine in [kMinLtcCosine, 1].
LtcFit FitLtc(double roughness, double cosine, const LtcLobe& start);

// A start that any entry may be fitted from, if slowly: as wide as the roughness says.
LtcLobe PlainLobe(double roughness);

}  // namespace halfshade
