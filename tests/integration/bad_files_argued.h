// Files of data/bad whose expectation we do not share, or share only in part, and why.
#pragma once

#include <map>
#include <string>

namespace halfshade {

struct Argument {
  const char* objection = "";  // what the manifest has against us
  const char* why = "";
};

// By file.
std::map<std::string, Argument> Arguments();

}  // namespace halfshade
