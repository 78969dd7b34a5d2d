// What each method may be off by, beyond its own sampling of the light, on each scene class: the table of the suite.
#pragma once

#include <string>
#include <vector>

namespace halfshade {

// Of visibility: the mean over shadowed pixels, and what 99.9 % of all pixels that face the light stay within.
struct ErrorPair {
  double mae_shadowed = 0;
  double p999 = 0;
};

struct ModelError {
  std::string scene;   // "S3"
  double light = 0.2;  // edge over the occluders' extent
  ErrorPair ground;    // over receivers alone
  ErrorPair all;       // self-shadow included
  std::string why;
};

struct MethodThresholds {
  std::string method;              // proto field name
  std::vector<ModelError> models;  // a scene and light that is not named: nothing beyond the sampling
};

const std::vector<MethodThresholds>& Thresholds();

}  // namespace halfshade
