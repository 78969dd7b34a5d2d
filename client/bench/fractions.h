// What one method costs beside the cheapest rival, and beside the cheapest of our own methods, at equal error. Pure.
//
// Rivals are the baselines: hard, multi_map, pcss and ray in whatever form. The rest are our own methods.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/bench/bench.h"

namespace halfshade::bench {

// One case at one error.
struct Fraction {
  double error = 0;      // mae_shadowed
  std::string own;       // the method's cheapest setting that is off by no more; empty: none is
  std::string rival;     // family of the cheapest rival; empty: none gets there
  double whole = 0;      // CPU time, primary visibility on both sides
  double shadow = 0;     // CPU time without it
  double p999 = 0;       // error at that share of the pixels
  std::string single;    // family of the cheapest of our other methods; empty: none gets there
  double of_single = 0;  // CPU time, primary visibility on both sides
  double aim = 0;        // of `whole`
  bool IsMissed() const { return own.empty() || (!rival.empty() && whole > aim); }
};

// Errors of .03, .01, .005 and .002. The method's own settings stand as they are, one with a budget only for that
// budget; another's cost is interpolated between the settings of its family (Setting::family) along the line through
// their logarithms; beyond the coarsest it is that setting's cost, beyond the finest it does not get there.
std::vector<Fraction> FractionsOf(const CaseResult& result, const std::string& method);

// The cost, or another figure, at error `at` of settings (cost, error), all > 0.
std::optional<double> FigureAt(const std::vector<double>& cost, const std::vector<double>& error,
                               const std::vector<double>& figure, double at);

}  // namespace halfshade::bench
