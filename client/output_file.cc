#include "client/output_file.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "client/exit_code.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;

absl::Status CannotWrite(const std::string& path) {
  return CannotWriteError(absl::StrCat(path, ": ", std::strerror(errno)));
}

// Where the bytes go once links are followed.
fs::path ResolveTarget(const std::string& path) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path);
  const fs::path target = fs::weakly_canonical(absolute, error);
  return error ? absolute : target;
}

absl::Status WriteAll(int file, const OutputFile& output) {
  size_t done = 0;
  while (done < output.bytes.size()) {
    const ssize_t count = write(file, output.bytes.data() + done, output.bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return CannotWrite(output.path);
    done += static_cast<size_t>(count);
  }
  return fsync(file) == 0 ? absl::OkStatus() : CannotWrite(output.path);
}

// A file under a temporary name that vanishes unless it is renamed.
class TemporaryFile {
 public:
  TemporaryFile() = default;
  TemporaryFile(TemporaryFile&& other) noexcept : name_(std::exchange(other.name_, {})) {}
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  ~TemporaryFile() {
    if (!name_.empty()) unlink(name_.c_str());
  }

  absl::Status Write(const fs::path& target, const OutputFile& output) {
    std::string name = (target.parent_path() / ".halfshade-XXXXXX").string();
    const int file = mkostemp(name.data(), O_CLOEXEC);
    if (file < 0) return CannotWrite(output.path);
    name_ = name;
    absl::Status status = WriteAll(file, output);
    const mode_t mask = umask(0);
    umask(mask);
    if (status.ok() && fchmod(file, 0666 & ~mask) != 0) status = CannotWrite(output.path);
    if (close(file) != 0 && status.ok()) status = CannotWrite(output.path);
    return status;
  }
  absl::Status RenameTo(const fs::path& target, const OutputFile& output) {
    if (rename(name_.c_str(), target.c_str()) != 0) return CannotWrite(output.path);
    name_.clear();
    return absl::OkStatus();
  }

 private:
  std::string name_;
};

}  // namespace

absl::Status CheckCanWrite(const std::string& path) {
  const fs::path target = ResolveTarget(path);
  struct stat info {};
  if (stat(target.c_str(), &info) == 0 && !S_ISREG(info.st_mode)) {
    return CannotWriteError(absl::StrCat(path, ": exists and is not a regular file"));
  }
  return access(target.parent_path().c_str(), W_OK | X_OK) == 0 ? absl::OkStatus() : CannotWrite(path);
}

absl::Status WriteOutputFiles(const std::vector<OutputFile>& files) {
  std::vector<TemporaryFile> temporaries(files.size());
  for (size_t i = 0; i < files.size(); ++i) {
    RETURN_IF_ERROR(CheckCanWrite(files[i].path));
    RETURN_IF_ERROR(temporaries[i].Write(ResolveTarget(files[i].path), files[i]));
  }
  for (size_t i = 0; i < files.size(); ++i) {
    RETURN_IF_ERROR(temporaries[i].RenameTo(ResolveTarget(files[i].path), files[i]));
  }
  return absl::OkStatus();
}

}  // namespace halfshade
