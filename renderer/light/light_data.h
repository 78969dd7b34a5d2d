// What a shadow method makes of a light before there is a camera.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "renderer/request.h"

namespace halfshade {

// A pure function of (scene and pose, light, options, seed), never of the camera: kept on its context for the requests
// to come. Owns all it needs. Lives on its context's thread.
class LightData {
 public:
  virtual ~LightData() = default;
  virtual uint64_t SizeBytes() const = 0;
  virtual uint64_t MapsDrawn() const = 0;  // while building
  // Maps that did not fit LightInputs::max_light_data_bytes: drawn at every resolve, the same ones.
  virtual uint64_t MapsRedrawn() const { return 0; }
  // Options that the request left open and that were chosen by what the light and the scene are, for the report.
  virtual std::vector<std::pair<std::string, std::string>> ChosenOptions() const { return {}; }
};

// Everything that light data is a function of, as bytes, and nothing else: equal keys, equal light data. Begins with
// LightDataPrefix(scene_name). Of the light its place and size alone: lights of any radiance share. Of node overrides
// what moves, casts or receives. `options` are those of the method that its light data depends on, as text.
std::string LightDataKey(const std::string& scene_name, const RenderRequest& request, const AreaLight& side,
                         const std::string& method, const std::string& options);
std::string LightDataPrefix(const std::string& scene_name);
// What light data of a ReceiverMap depends on besides, as bytes.
std::string ReceiverMapKey(const RenderRequest& request);
// The same of what casts, wherever the light is: begins with LightDataPrefix(scene_name).
std::string CastersKey(const std::string& scene_name, const RenderRequest& request);

}  // namespace halfshade
