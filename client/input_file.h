// Reads files that the user named. Only regular files: never a device, a pipe or a folder.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

namespace halfshade {

// The server's own limit is far lower; this one keeps a sparse file from taking the machine's memory.
inline constexpr uint64_t kMaxInputBytes = 4ull << 30;

// The file's bytes. NOT_FOUND where it is absent, not readable or not a regular file; INVALID_ARGUMENT over
// kMaxInputBytes. The message starts with `path`.
absl::StatusOr<std::string> ReadInputFile(const std::string& path);

// Whether ReadInputFile would find a regular file there: NOT_FOUND if not.
absl::Status CheckInputFile(const std::string& path);

}  // namespace halfshade
