#include "client/private_folder.h"

#include <absl/strings/str_cat.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <thread>
#include <utility>

namespace halfshade {
namespace {

void Remove(const std::string& path) {
  std::error_code error;
  std::filesystem::remove_all(path, error);
}

sigset_t EndingSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  return signals;
}

void RemoveOnSignal(const std::string& path) {
  const sigset_t signals = EndingSignals();
  int received = 0;
  if (sigwait(&signals, &received) != 0) return;
  Remove(path);
  signal(received, SIG_DFL);
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  kill(getpid(), received);
}

}  // namespace

absl::StatusOr<PrivateFolder> PrivateFolder::Create() {
  std::error_code error;
  std::string pattern = (std::filesystem::temp_directory_path(error) / "halfshade-XXXXXX").string();
  if (error || mkdtemp(pattern.data()) == nullptr) {
    return absl::UnavailableError(absl::StrCat("a temporary folder (", pattern, "): ", std::strerror(errno)));
  }
  PrivateFolder folder;
  folder.path_ = pattern;
  const sigset_t signals = EndingSignals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread(RemoveOnSignal, pattern).detach();
  return folder;
}

PrivateFolder::PrivateFolder(PrivateFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}

PrivateFolder::~PrivateFolder() {
  if (!path_.empty()) Remove(path_);
}

}  // namespace halfshade
