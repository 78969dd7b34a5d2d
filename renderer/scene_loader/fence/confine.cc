#include "renderer/scene_loader/fence/confine.h"

#include <seccomp.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <new>
#include <string>

#include "renderer/status.h"

namespace halfshade {
namespace {

#if !defined(__has_feature)
#define __has_feature(feature) 0
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || __has_feature(address_sanitizer)
constexpr bool kHasSanitizer = true;  // which reserves terabytes
#else
constexpr bool kHasSanitizer = false;
#endif

absl::Status Refused(const char* what, int error) {
  return absl::FailedPreconditionError(std::string(what) + ": " + std::strerror(error));
}

absl::Status SetLimit(const char* what, int resource, rlim_t soft, rlim_t hard) {
  const struct rlimit limit = {soft, hard};
  return setrlimit(__rlimit_resource_t(resource), &limit) == 0 ? absl::OkStatus() : Refused(what, errno);
}

// Only what follows is allowed, of some calls only with these arguments.
absl::Status AllowOnlyReading() {
  const std::unique_ptr<void, void (*)(scmp_filter_ctx)> filter(seccomp_init(SCMP_ACT_KILL_PROCESS), seccomp_release);
  if (filter == nullptr) return Refused("seccomp", ENOMEM);
  int error = 0;
  const auto allow = [&](int call, std::initializer_list<scmp_arg_cmp> arguments = {}) {
    if (error == 0) {
      error = seccomp_rule_add_array(filter.get(), SCMP_ACT_ALLOW, call, unsigned(arguments.size()), arguments.begin());
    }
  };
  allow(SCMP_SYS(read), {SCMP_A0_32(SCMP_CMP_EQ, STDIN_FILENO)});
  for (const unsigned file : {STDOUT_FILENO, STDERR_FILENO}) allow(SCMP_SYS(write), {SCMP_A0_32(SCMP_CMP_EQ, file)});
  // Memory, but none that can be executed and none of a file.
  allow(SCMP_SYS(mmap),
        {SCMP_A2_32(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0), SCMP_A3_32(SCMP_CMP_MASKED_EQ, MAP_ANONYMOUS, MAP_ANONYMOUS)});
  allow(SCMP_SYS(mprotect), {SCMP_A2_32(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0)});
  for (const int call : {SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(brk), SCMP_SYS(madvise)}) allow(call);
  // Its own end, and what the C library does on the way there.
  allow(SCMP_SYS(tgkill), {SCMP_A0_32(SCMP_CMP_EQ, unsigned(getpid()))});
  for (const int call :
       {SCMP_SYS(exit), SCMP_SYS(exit_group), SCMP_SYS(rt_sigreturn), SCMP_SYS(rt_sigprocmask), SCMP_SYS(getpid),
        SCMP_SYS(gettid), SCMP_SYS(futex), SCMP_SYS(sched_yield), SCMP_SYS(clock_gettime), SCMP_SYS(getrandom)}) {
    allow(call);
  }
  if (error == 0) error = seccomp_load(filter.get());  // sets no-new-privileges first
  return error == 0 ? absl::OkStatus() : Refused("seccomp", -error);
}

}  // namespace

absl::Status Confine(const ConfineLimits& limits) {
  std::set_new_handler([] { _exit(kExitNoMemory); });
  if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) return Refused("PR_SET_PDEATHSIG", errno);
  if (prctl(PR_SET_DUMPABLE, 0) != 0) return Refused("PR_SET_DUMPABLE", errno);
  RETURN_IF_ERROR(SetLimit("RLIMIT_CORE", RLIMIT_CORE, 0, 0));
  RETURN_IF_ERROR(SetLimit("RLIMIT_CPU", RLIMIT_CPU, limits.cpu_s, limits.cpu_s + 1));
  RETURN_IF_ERROR(SetLimit("RLIMIT_FSIZE", RLIMIT_FSIZE, limits.memory_bytes, limits.memory_bytes));
  if (!kHasSanitizer) {
    RETURN_IF_ERROR(SetLimit("RLIMIT_AS", RLIMIT_AS, limits.memory_bytes, limits.memory_bytes));
  }
  return AllowOnlyReading();
}

}  // namespace halfshade
