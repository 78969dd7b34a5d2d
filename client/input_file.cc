#include "client/input_file.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "renderer/status.h"

namespace halfshade {
namespace {

absl::Status NoInput(const std::string& path, const std::string& why) {
  return absl::NotFoundError(absl::StrCat(path, ": ", why));
}

}  // namespace

absl::Status CheckInputFile(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return NoInput(path, std::strerror(errno));
  return S_ISREG(info.st_mode) ? absl::OkStatus() : NoInput(path, "is not a regular file");
}

absl::StatusOr<std::string> ReadInputFile(const std::string& path) {
  // Asked before opening too: opening a device can do things.
  RETURN_IF_ERROR(CheckInputFile(path));
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
  if (file < 0) return NoInput(path, std::strerror(errno));
  struct stat info {};
  std::string bytes;
  absl::Status status;
  if (fstat(file, &info) != 0 || !S_ISREG(info.st_mode)) {
    status = NoInput(path, "is not a regular file");
  } else if (static_cast<uint64_t>(info.st_size) > kMaxInputBytes) {
    status = absl::InvalidArgumentError(
        absl::StrCat(path, ": ", info.st_size, " bytes; at most ", kMaxInputBytes, " are read"));
  } else {
    bytes.resize(static_cast<size_t>(info.st_size));
    size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t count = read(file, bytes.data() + done, bytes.size() - done);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) status = NoInput(path, std::strerror(errno));
      if (count <= 0) break;
      done += static_cast<size_t>(count);
    }
    bytes.resize(done);
  }
  close(file);
  if (!status.ok()) return status;
  return bytes;
}

}  // namespace halfshade
