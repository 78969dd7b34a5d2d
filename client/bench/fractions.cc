#include "client/bench/fractions.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <string_view>

#include "client/bench/statistics.h"

namespace halfshade::bench {
namespace {

// A cost below the clock's own noise counts as that.
constexpr double kLeastMs = 0.1;
constexpr double kLeastError = 1e-9;

struct Aim {
  double error, whole, dense;
};
constexpr Aim kAims[] = {{0.03, 0.5, 1}, {0.01, 0.2, 0.5}, {0.005, 0.1, 0.25}, {0.002, 0.1, 0.2}};

// Settings of one family, in turns: CPU time with and without primary visibility, and errors.
struct Family {
  std::vector<double> whole, shadow, error, p999;
};

struct Cheapest {
  std::string name;  // empty: none gets there
  double whole = 0, shadow = 0, p999 = 0;
};

bool IsBaseline(const std::string& method) {
  constexpr std::string_view kBaselines[] = {"hard", "multi_map", "pcss", "ray"};
  return std::find(std::begin(kBaselines), std::end(kBaselines), method) != std::end(kBaselines);
}

// Rays that a budget stops are our own.
bool IsRival(const Setting& setting) { return IsBaseline(setting.method) && setting.max_error == 0; }

void Add(const Row& row, Family* family) {
  family->whole.push_back(std::max(kLeastMs, row.cpu_ms));
  family->shadow.push_back(std::max(kLeastMs, row.shadow_cpu_ms));
  family->error.push_back(std::max(kLeastError, row.error.mae_shadowed.value_or(0)));
  family->p999.push_back(std::max(kLeastError, row.error.p999.value_or(0)));
}

Cheapest CheapestAt(const std::map<std::string, Family>& families, double error) {
  Cheapest best;
  for (const auto& [name, family] : families) {
    const std::optional<double> cost = FigureAt(family.whole, family.error, family.whole, error);
    if (!cost || (!best.name.empty() && *cost >= best.whole)) continue;
    best = {name, *cost, FigureAt(family.whole, family.error, family.shadow, error).value_or(*cost),
            FigureAt(family.whole, family.error, family.p999, error).value_or(0)};
  }
  return best;
}

// Of the rows that stand for this error as they are.
Cheapest CheapestOwn(const CaseResult& result, const std::string& method, double error) {
  Cheapest best;
  for (const Row& row : result.rows) {
    const Setting& setting = row.setting;
    if (!row.failure.empty() || setting.method != method || row.error.mae_shadowed.value_or(0) > error) continue;
    if (setting.max_error > 0 && setting.max_error != error) continue;
    if (!best.name.empty() && row.cpu_ms >= best.whole) continue;
    best = {setting.label, std::max(kLeastMs, row.cpu_ms), std::max(kLeastMs, row.shadow_cpu_ms),
            std::max(kLeastError, row.error.p999.value_or(0))};
  }
  return best;
}

}  // namespace

std::optional<double> FigureAt(const std::vector<double>& cost, const std::vector<double>& error,
                               const std::vector<double>& figure, double at) {
  const std::vector<bool> is_on_front = ParetoFront(cost, error);
  std::vector<std::pair<double, double>> front;  // error, figure: coarsest first
  for (size_t i = 0; i < cost.size(); ++i) {
    if (is_on_front[i]) front.emplace_back(error[i], figure[i]);
  }
  std::sort(front.rbegin(), front.rend());
  for (size_t i = 0; i < front.size(); ++i) {
    if (front[i].first > at) continue;
    if (i == 0) return front[0].second;
    const auto& [coarse, low] = front[i - 1];
    const auto& [fine, high] = front[i];
    const double share = std::log(coarse / at) / std::log(coarse / fine);
    return low * std::pow(high / low, share);
  }
  return std::nullopt;
}

std::vector<Fraction> FractionsOf(const CaseResult& result, const std::string& method) {
  std::map<std::string, Family> rivals, singles;
  for (const Row& row : result.rows) {
    if (!row.failure.empty() || row.setting.method == method) continue;
    Add(row, &(IsRival(row.setting) ? rivals : singles)[row.setting.family]);
  }
  std::vector<Fraction> fractions;
  for (const Aim& aim : kAims) {
    Fraction& fraction = fractions.emplace_back();
    fraction.error = aim.error;
    fraction.aim = result.is_dense ? aim.dense : aim.whole;
    const Cheapest own = CheapestOwn(result, method, aim.error);
    const Cheapest rival = CheapestAt(rivals, aim.error), single = CheapestAt(singles, aim.error);
    fraction.own = own.name;
    fraction.rival = rival.name;
    fraction.single = single.name;
    if (own.name.empty()) continue;
    if (!single.name.empty()) fraction.of_single = own.whole / single.whole;
    if (rival.name.empty()) continue;
    fraction.whole = own.whole / rival.whole;
    fraction.shadow = own.shadow / rival.shadow;
    fraction.p999 = own.p999 / rival.p999;
  }
  return fractions;
}

}  // namespace halfshade::bench
