// Prints ltc_table.inc: every entry of the table, fitted. About two minutes on two cores.
#include <cstdio>
#include <thread>
#include <vector>

#include "renderer/shade/ltc/fit.h"

namespace halfshade {
namespace {

size_t EntryAt(int row, int column) { return size_t(kLtcSize) * size_t(row) + size_t(column); }

void PrintTable() {
  // Each lobe starts from its neighbour's: seen along the normal from the rougher one, elsewhere from the steeper view.
  std::vector<LtcFit> fits(size_t{kLtcSize} * kLtcSize);
  LtcLobe start = PlainLobe(1);
  for (int row = kLtcSize - 1; row >= 0; --row) {
    fits[EntryAt(row, 0)] = FitLtc(LtcRoughness(row), LtcCosine(0), start);
    start = fits[EntryAt(row, 0)].lobe;
  }
  const auto fit_rows = [&](int first) {
    for (int row = first; row < kLtcSize; row += 2) {
      for (int column = 1; column < kLtcSize; ++column) {
        const size_t i = EntryAt(row, column);
        fits[i] = FitLtc(LtcRoughness(row), LtcCosine(column), fits[i - 1].lobe);
      }
    }
  };
  std::thread odd(fit_rows, 1);
  fit_rows(0);
  odd.join();
  std::puts("// Made by fit_ltc. m11, m13, m31, m33, albedo, grazing; rows of roughness, columns of the view.");
  for (const LtcFit& fit : fits) {
    const LtcEntry& e = fit.entry;
    std::printf("{%.6g,%.6g,%.6g,%.6g,%.6g,%.6g},\n", e.m11, e.m13, e.m31, e.m33, e.albedo, e.grazing);
  }
}

}  // namespace
}  // namespace halfshade

int main() { halfshade::PrintTable(); }
