// The outside of a glTF: GLB chunks or plain JSON, bounded and scanned before anything parses it.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "renderer/scene_loader/scene_loader.h"

namespace halfshade {

struct GltfContainer {
  std::string json;
  const char* bin = nullptr;  // GLB's BIN chunk, inside the root's bytes; null without one
  size_t bin_size = 0;
  bool is_glb = false;
  size_t trailing_bytes = 0;  // after GLB's end
};

// INVALID_ARGUMENT "GLB: ..." for a broken container; "JSON: ..." for one over the limits on size and nesting (counted
// over the text, so that no parser's stack depends on it).
absl::StatusOr<GltfContainer> OpenContainer(const std::string& root, const SceneLoadLimits& limits);

// "%20" -> " ". False for a malformed escape.
bool PercentDecode(const std::string& text, std::string* decoded);

bool IsDataUri(const std::string& uri);
// The bytes of "data:...;base64,...". False if it is malformed.
bool DecodeDataUri(const std::string& uri, std::string* bytes);

}  // namespace halfshade
