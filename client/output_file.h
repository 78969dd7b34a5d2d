// Writes result files whole or not at all: into a temporary file beside the target, then renamed.
#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

namespace halfshade {

struct OutputFile {
  std::string path;
  std::string bytes;
};

// Tells before any work is done what would make WriteOutputFiles fail: no such folder, a folder that cannot be written,
// a target that exists and is not a regular file. Exit code 74, naming the path.
absl::Status CheckCanWrite(const std::string& path);

// Every file is complete under a temporary name before the first is renamed, so a full disk leaves none of them. A link
// as target is followed. Exit code 74, naming the path; no temporary file is left.
absl::Status WriteOutputFiles(const std::vector<OutputFile>& files);

}  // namespace halfshade
