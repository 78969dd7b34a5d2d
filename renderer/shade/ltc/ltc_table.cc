#include "renderer/shade/ltc/ltc_table.h"

#include <algorithm>
#include <cmath>

namespace halfshade {
namespace {

LtcEntry Mix(const LtcEntry& a, const LtcEntry& b, double t) {
  const auto mix = [t](double x, double y) { return x + (y - x) * t; };
  return {mix(a.m11, b.m11), mix(a.m13, b.m13),       mix(a.m31, b.m31),
          mix(a.m33, b.m33), mix(a.albedo, b.albedo), mix(a.grazing, b.grazing)};
}

}  // namespace

double LtcRoughness(int row) { return kMinLtcRoughness + (1 - kMinLtcRoughness) * row / (kLtcSize - 1); }

double LtcCosine(int column) {
  const double step = double(column) / (kLtcSize - 1);
  return std::max(1 - step * step, kMinLtcCosine);
}

const std::array<LtcEntry, std::size_t{kLtcSize} * kLtcSize>& LtcTable() {
  static const std::array<LtcEntry, std::size_t{kLtcSize}* kLtcSize> table = {{
#include "renderer/shade/ltc/ltc_table.inc"
  }};
  return table;
}

LtcEntry InterpolateLtc(double roughness, double cosine) {
  const double r = std::clamp((roughness - kMinLtcRoughness) / (1 - kMinLtcRoughness), 0.0, 1.0) * (kLtcSize - 1);
  const double c = std::sqrt(1 - std::clamp(cosine, 0.0, 1.0)) * (kLtcSize - 1);
  const int row = std::min(int(r), kLtcSize - 2);
  const int column = std::min(int(c), kLtcSize - 2);
  const LtcEntry* corner = &LtcTable()[size_t{kLtcSize} * size_t(row) + size_t(column)];
  return Mix(Mix(corner[0], corner[1], c - column), Mix(corner[kLtcSize], corner[kLtcSize + 1], c - column), r - row);
}

double LtcShareAbove(const LtcEntry& entry) {
  return 0.5 * (1 + entry.m11 / std::sqrt(entry.m11 * entry.m11 + entry.m31 * entry.m31));
}

}  // namespace halfshade
