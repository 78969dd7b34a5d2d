#include "client/bench/fractions.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "client/bench/statistics.h"

namespace halfshade::bench {
namespace {

// A cost below the clock's own noise counts as that.
constexpr double kLeastMs = 0.1;

struct Aim {
  double error, whole, dense;
};
constexpr Aim kAims[] = {{0.03, 0.5, 1}, {0.01, 0.2, 0.5}, {0.005, 0.1, 0.25}, {0.002, 0.1, 0.2}};

struct Family {
  std::vector<double> whole, shadow, error;
};

}  // namespace

std::optional<double> CostAt(const std::vector<double>& cost, const std::vector<double>& error, double at) {
  const std::vector<bool> is_on_front = ParetoFront(cost, error);
  std::vector<std::pair<double, double>> front;  // error, cost: coarsest first
  for (size_t i = 0; i < cost.size(); ++i) {
    if (is_on_front[i]) front.emplace_back(error[i], cost[i]);
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
  std::map<std::string, Family> rivals;
  for (const Row& row : result.rows) {
    if (!row.failure.empty() || row.setting.method == method) continue;
    Family& family = rivals[row.setting.family];
    family.whole.push_back(std::max(kLeastMs, row.cpu_ms));
    family.shadow.push_back(std::max(kLeastMs, row.shadow_cpu_ms));
    family.error.push_back(std::max(1e-9, row.error.mae_shadowed.value_or(0)));
  }
  std::vector<Fraction> fractions;
  for (const Aim& aim : kAims) {
    Fraction& fraction = fractions.emplace_back();
    fraction.error = aim.error;
    fraction.aim = result.is_dense ? aim.dense : aim.whole;
    double whole = 0, shadow = 0;
    for (const Row& row : result.rows) {
      if (!row.failure.empty() || row.setting.method != method) continue;
      if (row.error.mae_shadowed.value_or(0) > aim.error || (!fraction.own.empty() && row.cpu_ms >= whole)) continue;
      fraction.own = row.setting.label;
      whole = std::max(kLeastMs, row.cpu_ms);
      shadow = std::max(kLeastMs, row.shadow_cpu_ms);
    }
    double rival_whole = 0, rival_shadow = 0;
    for (const auto& [name, family] : rivals) {
      const std::optional<double> cost = CostAt(family.whole, family.error, aim.error);
      if (!cost || (!fraction.rival.empty() && *cost >= rival_whole)) continue;
      fraction.rival = name;
      rival_whole = *cost;
      rival_shadow = CostAt(family.shadow, family.error, aim.error).value_or(*cost);
    }
    if (fraction.own.empty() || fraction.rival.empty()) continue;
    fraction.whole = whole / rival_whole;
    fraction.shadow = shadow / rival_shadow;
  }
  return fractions;
}

}  // namespace halfshade::bench
