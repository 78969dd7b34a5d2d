// What the server and the loader say to each other: one task, one answer, in bytes. Both ends are of one build.
//
// The task is trusted (the server wrote it), what it carries is not; the answer is not either: it is read with every
// size checked. Thread-safe: no state.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/renderer.h"
#include "renderer/scene/flat_form.h"
#include "renderer/scene_loader/scene_loader.h"

namespace halfshade {

struct LoaderTask {
  enum Kind : uint32_t { kLoad, kDecode };
  Kind kind = kLoad;
  SceneLoadLimits limits;  // kDecode: max_texture_pixels
  // kLoad: the root, then each file's URI and bytes. kDecode: the image's name and bytes.
  std::vector<std::string> texts;
};

// False where the sink said so.
bool WriteLoadTask(const std::string& root, const FileMap& files, const SceneLoadLimits& limits, const ByteSink& sink);
bool WriteDecodeTask(const EncodedImage& image, uint64_t max_pixels, const ByteSink& sink);

// Fills the buffer whole; false at the end.
using ByteSource = std::function<bool(void* bytes, size_t size)>;
bool ReadTask(const ByteSource& source, LoaderTask* task);

// Does what the task asks, by LoadGltf or DecodeImage, and writes what came of it: a status, and after OK the flat form
// or the texels. False where the sink said so.
bool AnswerTask(const LoaderTask& task, const ByteSink& sink);

// The loader's own status; INTERNAL for an answer that is none, is cut, or holds a scene that is not valid.
absl::StatusOr<FlatScene> ReadSceneAnswer(std::string_view answer);
absl::StatusOr<Rgba8Image> ReadImageAnswer(std::string_view answer);

}  // namespace halfshade
