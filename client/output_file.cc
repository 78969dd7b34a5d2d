#include "client/output_file.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <random>
#include <set>
#include <utility>

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

// ".out.png.0123456789abcdef.part"
constexpr char kTemporaryEnd[] = ".part";
constexpr size_t kTokenDigits = 16;
constexpr size_t kLongestName = 200;  // of the target, so that the temporary name stays below 255 bytes

std::string TemporaryName(const fs::path& target) {
  std::random_device random;
  return absl::StrCat((target.parent_path() / ".").string(), target.filename().string().substr(0, kLongestName), ".",
                      absl::Hex(random(), absl::kZeroPad8), absl::Hex(random(), absl::kZeroPad8), kTemporaryEnd);
}

// A file under a temporary name that vanishes unless it is renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(FileOperations* operations) : operations_(*operations) {}
  TemporaryFile(TemporaryFile&& other) noexcept
      : operations_(other.operations_), name_(std::exchange(other.name_, {})) {}
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  ~TemporaryFile() {
    if (!name_.empty()) operations_.Unlink(name_);
  }

  absl::Status Write(const fs::path& target, const OutputFile& output) {
    const std::string name = TemporaryName(target);
    const int file = operations_.Open(name, O_WRONLY | O_CREAT | O_EXCL, 0666);
    if (file < 0) return CannotWrite(output.path);
    name_ = name;
    absl::Status status;
    if (operations_.WriteAll(file, output.bytes.data(), output.bytes.size(), 0) != 0 || operations_.Sync(file) != 0) {
      status = CannotWrite(output.path);
    }
    operations_.Close(file);
    return status;
  }
  absl::Status RenameTo(const fs::path& target, const OutputFile& output) {
    if (operations_.Rename(name_, target.string()) != 0) return CannotWrite(output.path);
    name_.clear();
    return absl::OkStatus();
  }

 private:
  FileOperations& operations_;
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

absl::Status WriteOutputFiles(const std::vector<OutputFile>& files, FileOperations* operations) {
  std::vector<TemporaryFile> temporaries;
  std::set<std::string> folders;
  for (const OutputFile& file : files) {
    RETURN_IF_ERROR(CheckCanWrite(file.path));
    const fs::path target = ResolveTarget(file.path);
    folders.insert(target.parent_path().string());
    temporaries.emplace_back(operations);
    RETURN_IF_ERROR(temporaries.back().Write(target, file));
  }
  for (size_t i = 0; i < files.size(); ++i) {
    RETURN_IF_ERROR(temporaries[i].RenameTo(ResolveTarget(files[i].path), files[i]));
  }
  for (const std::string& folder : folders) {
    if (operations->SyncFolder(folder) != 0) return CannotWrite(folder);
  }
  return absl::OkStatus();
}

std::string TargetOfTemporary(const std::string& name) {
  constexpr size_t kAdded = 1 + kTokenDigits + sizeof(kTemporaryEnd) - 1;
  if (name.size() <= 1 + kAdded || name[0] != '.' || !absl::EndsWith(name, kTemporaryEnd)) return "";
  const std::string token = name.substr(name.size() - kAdded + 1, kTokenDigits);
  const bool is_token =
      name[name.size() - kAdded] == '.' && std::all_of(token.begin(), token.end(), absl::ascii_isxdigit);
  return is_token ? name.substr(1, name.size() - kAdded - 1) : "";
}

}  // namespace halfshade
