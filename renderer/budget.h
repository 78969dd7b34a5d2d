// Whether a picture kept its budget. Pure.
#pragma once

#include <string>

#include "renderer/report.h"
#include "renderer/request.h"

namespace halfshade {

// "0.01; the error is 0.02 as predicted": how the picture broke max_error; empty: it did not. What is measured counts
// by its interval; where that reaches over the bound on both sides, what is predicted decides.
std::string FindBreach(const ErrorReport& error, const Budget& budget);

}  // namespace halfshade
