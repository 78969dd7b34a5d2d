// The commands of `halfshade`, one function each. They print data to stdout and words to stderr; what fails comes back
// as a status (client/exit_code.h says what it exits with).
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <string>
#include <vector>

#include "client/render_flags.h"

namespace halfshade {

// Flags that stand before or after the command.
struct GlobalFlags {
  std::string servers;  // --server, HALFSHADE_SERVER: "host:port,host:port"; empty: the service in this process
  bool wants_json = false;
  std::string gl = "auto";  // auto, egl, osmesa
  int egl_device = -1;
  int contexts = 1;
  double timeout_s = 600;  // the longest that a server allows
};

struct RenderCommand {
  RenderFlags flags;
  bool prints_request = false;
};

// Of the service in this process; results go into `folder`.
struct BenchCommand {
  std::vector<std::string> scenes;  // files, or view files; empty: the suite
  std::string suite = "quick";      // quick, full; smoke for tests
  std::string folder;
};

// Several batches may write into one folder, on different items.
struct BatchCommand {
  std::string requests_file;  // client/batch/batch_file.h
  std::string folder;
  int jobs = 4;              // calls in flight, 1 to 256
  std::string shard;         // "I/N", 0 <= I < N; empty: all
  bool resumes = false;      // what is in the folder whole is left as it is
  bool keeps_going = false;  // after a failure
};

struct SampleCommand {
  std::string template_file;  // client/batch/sample.h
  uint64_t count = 1000;
  uint64_t seed = 0;
};

struct PackCommand {
  std::string folder;     // of a batch
  std::string to_folder;  // made where it is absent
  int shard_mb = 256;     // 1 to 4096: held in memory
};

struct CompareCommand {
  std::string reference;
  std::string tested;
  std::string mask;  // empty: every pixel counts
  std::string size;  // WIDTHxHEIGHT of files without a header
};

absl::Status RunCompare(const GlobalFlags& global, const CompareCommand& command);
absl::Status RunRender(const GlobalFlags& global, const RenderCommand& command);
// What RunRender would do, and what it would leave out.
absl::Status RunPlan(const GlobalFlags& global, const RenderFlags& flags);
// Visibility of every light from the points of a CSV file (client/points_file.h): a line a point, a value a light.
absl::Status RunQuery(const GlobalFlags& global, const RenderFlags& flags, const std::string& points_file);
absl::Status RunUpload(const GlobalFlags& global, const std::string& file);
absl::Status RunScenes(const GlobalFlags& global);
absl::Status RunScene(const GlobalFlags& global, const std::string& scene);
absl::Status RunInfo(const GlobalFlags& global);
absl::Status RunHealth(const GlobalFlags& global);
absl::Status RunDoctor(const GlobalFlags& global);
absl::Status RunBatch(const GlobalFlags& global, const BatchCommand& command);
// Lines of a batch, to stdout.
absl::Status RunSample(const GlobalFlags& global, const SampleCommand& command);
// Tar files out of a batch's folder (client/batch/pack.h).
absl::Status RunPack(const GlobalFlags& global, const PackCommand& command);
absl::Status RunBench(const GlobalFlags& global, const BenchCommand& command);

}  // namespace halfshade
