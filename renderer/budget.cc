#include "renderer/budget.h"

#include <iomanip>
#include <sstream>

namespace halfshade {
namespace {

std::string Decimal(double value) {
  std::ostringstream text;
  text << std::setprecision(3) << value;
  return text.str();
}

}  // namespace

std::string FindBreach(const ErrorReport& error, const Budget& budget) {
  if (!budget.max_error) return "";
  const std::string over = Decimal(*budget.max_error) + "; the error is ";
  if (error.measured) {
    const double measured = *error.measured, ci95 = error.ci95.value_or(0);
    if (measured + ci95 <= *budget.max_error) return "";
    if (measured - ci95 > *budget.max_error || !error.predicted) {
      return over + Decimal(measured) + " +- " + Decimal(ci95) + " as measured";
    }
  }
  if (!error.predicted || *error.predicted <= *budget.max_error) return "";
  return over + Decimal(*error.predicted) + " as predicted";
}

}  // namespace halfshade
