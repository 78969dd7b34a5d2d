// A name for one call, in its errors and in the log.
#pragma once

#include <string>

namespace halfshade {

// Six hex digits of this process, and a number.
std::string NextRequestId();

}  // namespace halfshade
