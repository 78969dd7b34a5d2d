// Takes from this process what reading a stranger's bytes does not need.
#pragma once

#include <absl/status/status.h>

#include <cstdint>

namespace halfshade {

struct ConfineLimits {
  uint64_t memory_bytes = 0;  // address space; and of the answer besides
  uint32_t cpu_s = 0;
};

// How the loader ends where it has no answer to write; anything else is a crash.
enum LoaderExit : int {
  kExitAnswered = 0,
  kExitUsage = 64,
  kExitNoFence = 70,   // this system does not let the process be confined: nothing was read
  kExitNoTask = 74,    // the task cannot be read, or the answer not be written
  kExitNoMemory = 75,  // operator new failed
};

// From here on the process reads descriptor 0, writes 1 and 2, takes memory up to the limit and ends: any other system
// call kills it (SIGSYS), so it opens no file, makes no socket and starts no process. CPU time over the limit kills it
// (SIGXCPU), memory over the limit ends it (kExitNoMemory); so does its parent's end (SIGKILL). It leaves no core.
// Needs no privilege (no-new-privileges and seccomp, libseccomp); a process with sanitizers keeps its address space.
// FAILED_PRECONDITION with what the system refuses.
absl::Status Confine(const ConfineLimits& limits);

}  // namespace halfshade
