// Numbers out of repeated measurements. Pure.
#pragma once

#include <vector>

namespace halfshade::bench {

// The middle one, or the mean of the two in the middle. Requires at least one value.
double Median(std::vector<double> values);

// p of the least-squares fit y = c x^p. Requires at least two different x, all values > 0.
double PowerLawExponent(const std::vector<double>& x, const std::vector<double>& y);

// Whether each point (cost, error) is beaten by none: no other point is at most as large in both and smaller in one.
std::vector<bool> ParetoFront(const std::vector<double>& cost, const std::vector<double>& error);

}  // namespace halfshade::bench
