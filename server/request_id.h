// A name for one call, in its errors and in the log.
#pragma once

#include <string>

namespace halfshade {

// Unique in this process: "r" and a number.
std::string NextRequestId();

}  // namespace halfshade
