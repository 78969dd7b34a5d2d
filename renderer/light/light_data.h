// What a shadow method makes of a light before there is a camera.
#pragma once

#include <cstdint>

namespace halfshade {

// A pure function of (scene and pose, light, options, seed), never of the camera. Lives on its context's thread.
class LightData {
 public:
  virtual ~LightData() = default;
  virtual uint64_t SizeBytes() const = 0;
  virtual uint64_t MapsDrawn() const = 0;  // while building
};

}  // namespace halfshade
