// A folder under the system's temporary one, for the scene store of the service in this process.
#pragma once

#include <absl/status/statusor.h>

#include <string>

namespace halfshade {

// Gone with its owner, and also when SIGINT, SIGTERM or SIGHUP ends the process (which then dies of that signal).
class PrivateFolder {
 public:
  // Call before any thread is started: the signals are blocked in the calling thread and in those that it starts.
  // UNAVAILABLE where the folder cannot be made.
  static absl::StatusOr<PrivateFolder> Create();
  PrivateFolder(PrivateFolder&& other) noexcept;
  PrivateFolder& operator=(PrivateFolder&&) = delete;
  ~PrivateFolder();

  const std::string& path() const { return path_; }

 private:
  PrivateFolder() = default;
  std::string path_;
};

}  // namespace halfshade
