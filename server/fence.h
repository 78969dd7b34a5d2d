// Reads each scene and each image in a process of its own, halfshade-scene-loader, which has no privilege but to
// answer (renderer/scene_loader/fence). What a stranger's bytes break is that process, and their own call.
//
// The bytes go in and the answer comes out through memory files, so nothing is needed of the file system; its
// environment is empty. As many run at a time as threads call. Starting one takes some milliseconds.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>

#include "server/scene_reader.h"

namespace halfshade {

struct FenceOptions {
  std::string loader;  // path of halfshade-scene-loader
  uint64_t memory_mb = 2048;
  // A second more for each kBytesPerSecond that are read. A process that takes `wall_s` is stuck: the other limits hold
  // it while it works.
  uint32_t cpu_s = 2;
  uint32_t wall_s = 30;
  static constexpr uint64_t kBytesPerSecond = 4 << 20;
};

class Fence final : public SceneReader {
 public:
  // Reads an empty scene to see that it stands: FAILED_PRECONDITION with what is wrong.
  static absl::StatusOr<std::unique_ptr<Fence>> Raise(const FenceOptions& options);

  // The loader's own errors; RESOURCE_EXHAUSTED with the limit where it took too much memory, CPU time or time;
  // INVALID_ARGUMENT where it died of anything else (the log says of what); INTERNAL where it cannot be started, or its
  // answer is none.
  absl::StatusOr<FlatScene> Load(const std::string& root, const FileMap& files, const SceneLoadLimits& limits) override;
  absl::StatusOr<Rgba8Image> Decode(const EncodedImage& image, uint64_t max_pixels) override;

  // What the loader took for the last task of this thread.
  static double last_cpu_s();

 private:
  struct Task;
  explicit Fence(const FenceOptions& options) : options_(options) {}
  absl::StatusOr<std::string> Run(const Task& task) const;

  const FenceOptions options_;
};

}  // namespace halfshade
