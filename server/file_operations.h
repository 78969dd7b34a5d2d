// The system calls that the store and the client's output files make, in one place, so that a test can let the nth of
// them fail or fall short.
#pragma once

#include <absl/status/status.h>
#include <sys/types.h>

#include <string>

namespace halfshade {

// Each as its system call: the result and errno. Thread-safe.
class FileOperations {
 public:
  virtual ~FileOperations() = default;
  // O_CLOEXEC; `mode` of a new file is cut by the umask: the owner's alone unless told.
  virtual int Open(const std::string& path, int flags, mode_t mode = 0600);
  virtual ssize_t Read(int file, void* bytes, size_t size, off_t offset);
  virtual ssize_t Write(int file, const void* bytes, size_t size, off_t offset);
  virtual int Truncate(int file, off_t size);
  virtual int Sync(int file);
  virtual int Rename(const std::string& from, const std::string& to);
  virtual int Unlink(const std::string& path);
  int Close(int file);  // cannot fail in a way that matters after Sync

  // The loops over the calls above. All of `size` bytes, or -1.
  int WriteAll(int file, const char* bytes, size_t size, off_t offset);
  // As many of `size` bytes as the file has from `offset` on, or -1.
  ssize_t ReadUpTo(int file, char* bytes, size_t size, off_t offset);
  // A folder's own entries: what makes a rename last.
  int SyncFolder(const std::string& path);
};

// The system's own.
FileOperations* SystemFiles();

// "what: strerror(errno)": RESOURCE_EXHAUSTED for a full disk or quota, else INTERNAL.
absl::Status FileError(const std::string& what);

}  // namespace halfshade
