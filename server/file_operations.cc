#include "server/file_operations.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace halfshade {

int FileOperations::Open(const std::string& path, int flags, mode_t mode) {
  return open(path.c_str(), flags | O_CLOEXEC, mode);
}
ssize_t FileOperations::Read(int file, void* bytes, size_t size, off_t offset) {
  return pread(file, bytes, size, offset);
}
ssize_t FileOperations::Write(int file, const void* bytes, size_t size, off_t offset) {
  return pwrite(file, bytes, size, offset);
}
int FileOperations::Truncate(int file, off_t size) { return ftruncate(file, size); }
int FileOperations::Sync(int file) { return fsync(file); }
int FileOperations::Rename(const std::string& from, const std::string& to) { return rename(from.c_str(), to.c_str()); }
int FileOperations::Unlink(const std::string& path) { return unlink(path.c_str()); }
int FileOperations::Close(int file) { return close(file); }

int FileOperations::WriteAll(int file, const char* bytes, size_t size, off_t offset) {
  size_t done = 0;
  while (done < size) {
    const ssize_t written = Write(file, bytes + done, size - done, offset + off_t(done));
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = EIO;  // or this would go on for ever
    if (written <= 0) return -1;
    done += size_t(written);
  }
  return 0;
}

ssize_t FileOperations::ReadUpTo(int file, char* bytes, size_t size, off_t offset) {
  size_t done = 0;
  while (done < size) {
    const ssize_t got = Read(file, bytes + done, size - done, offset + off_t(done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return -1;
    if (got == 0) break;
    done += size_t(got);
  }
  return ssize_t(done);
}

int FileOperations::SyncFolder(const std::string& path) {
  const int folder = Open(path, O_RDONLY | O_DIRECTORY);
  if (folder < 0) return -1;
  const int result = Sync(folder);
  const int error = errno;
  Close(folder);
  errno = error;
  return result;
}

FileOperations* SystemFiles() {
  static FileOperations files;
  return &files;
}

absl::Status FileError(const std::string& what) {
  const int error = errno;
  const std::string message = what + ": " + std::strerror(error);
  if (error == ENOSPC || error == EDQUOT) return absl::ResourceExhaustedError(message);
  return absl::InternalError(message);
}

}  // namespace halfshade
