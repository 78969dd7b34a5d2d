#include "client/bench/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace halfshade::bench {

double Median(std::vector<double> values) {
  assert(!values.empty());
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*std::max_element(values.begin(), middle) + *middle) / 2;
}

double PowerLawExponent(const std::vector<double>& x, const std::vector<double>& y) {
  assert(x.size() == y.size() && x.size() >= 2);
  double mean_x = 0, mean_y = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    mean_x += std::log(x[i]) / double(x.size());
    mean_y += std::log(y[i]) / double(x.size());
  }
  double covariance = 0, variance = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    covariance += (std::log(x[i]) - mean_x) * (std::log(y[i]) - mean_y);
    variance += (std::log(x[i]) - mean_x) * (std::log(x[i]) - mean_x);
  }
  return covariance / variance;
}

std::vector<bool> ParetoFront(const std::vector<double>& cost, const std::vector<double>& error) {
  assert(cost.size() == error.size());
  std::vector<bool> is_on_front(cost.size(), true);
  for (size_t i = 0; i < cost.size(); ++i) {
    for (size_t j = 0; j < cost.size(); ++j) {
      const bool is_no_worse = cost[j] <= cost[i] && error[j] <= error[i];
      if (is_no_worse && (cost[j] < cost[i] || error[j] < error[i])) is_on_front[i] = false;
    }
  }
  return is_on_front;
}

}  // namespace halfshade::bench
