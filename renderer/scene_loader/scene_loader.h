// glTF 2.0 bytes + the files uploaded with them -> FlatScene. The only room that includes tinygltf.
//
// Nothing is read but `files`: a URI names a key of that map and nothing else (no file system, no network).
// Thread-safe: no state.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <string>

#include "renderer/scene/flat_scene.h"

namespace halfshade {

struct SceneLoadLimits {
  uint64_t max_scene_bytes = 512ull << 20;  // root + files; again all accessors; again the flat scene's arrays
  uint64_t max_triangles = 20'000'000;      // of the meshes; their instances may have five times as many
  uint64_t max_json_bytes = 64ull << 20;
  uint32_t max_json_depth = 64;
  uint64_t max_texture_pixels = 64ull << 20;  // one image, from its header
};

// Relative URI (percent-decoded) -> bytes. Values outlive the call.
using FileMap = std::map<std::string, const std::string*>;

// Errors: INVALID_ARGUMENT, the message starting with the JSON pointer of the fault ("/accessors/3/bufferView: 7; the
// file has 2"), or with "GLB:" for the container; UNIMPLEMENTED never: what we do not have is refused by name with
// INVALID_ARGUMENT ("/extensionsRequired/0: \"EXT_texture_webp\" is not supported").
absl::StatusOr<FlatScene> LoadGltf(const std::string& root, const FileMap& files, const SceneLoadLimits& limits);

}  // namespace halfshade
