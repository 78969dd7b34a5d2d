// Writes result files whole or not at all: into a temporary file beside the target, then renamed.
#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

#include "server/file_operations.h"

namespace halfshade {

struct OutputFile {
  std::string path;
  std::string bytes;
};

// Tells before any work is done what would make WriteOutputFiles fail: no such folder, a folder that cannot be written,
// a target that exists and is not a regular file. Exit code 74, naming the path.
absl::Status CheckCanWrite(const std::string& path);

// Every file is complete and on disk under a temporary name before the first is renamed, so a full disk leaves none of
// them; the folders are on disk when it returns. A link as target is followed. Exit code 74, naming the path; no
// temporary file is left, unless the process is killed.
absl::Status WriteOutputFiles(const std::vector<OutputFile>& files, FileOperations* operations = SystemFiles());

// The name of the file that `name` is a killed writer's temporary one for; "" where it is none. (Of long names only the
// beginning.)
std::string TargetOfTemporary(const std::string& name);

}  // namespace halfshade
