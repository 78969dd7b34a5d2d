// The store's file operations, one of which fails.
#pragma once

#include <atomic>
#include <cerrno>

#include "server/file_operations.h"

namespace halfshade {

class FaultFiles : public FileOperations {
 public:
  // The nth call from now on fails with `error`. 0: a write that writes half of its bytes and whose next one fails with
  // EIO; other calls do not count.
  void FailAt(int nth, int error) {
    error_ = error;
    has_failed_ = false;
    left_ = nth;
  }
  bool has_failed() const { return has_failed_; }

  int Open(const std::string& path, int flags, mode_t mode) override {
    return Fails() ? -1 : FileOperations::Open(path, flags, mode);
  }
  ssize_t Read(int file, void* bytes, size_t size, off_t offset) override {
    return Fails() ? -1 : FileOperations::Read(file, bytes, size, offset);
  }
  ssize_t Write(int file, const void* bytes, size_t size, off_t offset) override {
    if (error_ != 0) return Fails() ? -1 : FileOperations::Write(file, bytes, size, offset);
    if (left_ == 2 && size > 1) {
      --left_;
      return FileOperations::Write(file, bytes, size / 2, offset);
    }
    return CountsDown(EIO) ? -1 : FileOperations::Write(file, bytes, size, offset);
  }
  int Truncate(int file, off_t size) override { return Fails() ? -1 : FileOperations::Truncate(file, size); }
  int Sync(int file) override { return Fails() ? -1 : FileOperations::Sync(file); }
  int Rename(const std::string& from, const std::string& to) override {
    return Fails() ? -1 : FileOperations::Rename(from, to);
  }
  // Never fails: what cannot be removed is swept at the next start, and no test of a running store holds it to more.
  int Unlink(const std::string& path) override { return FileOperations::Unlink(path); }

 private:
  bool Fails() { return error_ != 0 && CountsDown(error_); }
  bool CountsDown(int error) {
    if (left_ == 0 || --left_ > 0) return false;
    has_failed_ = true;
    errno = error;
    return true;
  }

  std::atomic<int> left_{0};
  std::atomic<int> error_{0};
  std::atomic<bool> has_failed_{false};
};

}  // namespace halfshade
