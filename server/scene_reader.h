// Who reads strangers' bytes: this process (ReadInProcess), or another one without privileges (fence.h).
// Thread-safe; blocks on what it reads.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>

#include "renderer/renderer.h"
#include "renderer/scene_loader/scene_loader.h"

namespace halfshade {

class SceneReader {
 public:
  virtual ~SceneReader() = default;
  // LoadGltf and its errors.
  virtual absl::StatusOr<FlatScene> Load(const std::string& root, const FileMap& files,
                                         const SceneLoadLimits& limits) = 0;
  // DecodeImage and its errors.
  virtual absl::StatusOr<Rgba8Image> Decode(const EncodedImage& image, uint64_t max_pixels) = 0;
};

// For files that are the caller's own: what they break is this process.
std::unique_ptr<SceneReader> ReadInProcess();

}  // namespace halfshade
