#include "server/fence.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <functional>
#include <utility>

#include "renderer/scene_loader/fence/confine.h"
#include "renderer/scene_loader/fence/descriptors.h"
#include "renderer/scene_loader/fence/message.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr size_t kMaxReason = 1024;  // of what a loader says on its way out

thread_local double cpu_s_of_last_task = 0;

absl::Status SystemError(const std::string& what, int error = errno) {
  return absl::InternalError("scene loader: " + what + ": " + std::strerror(error));
}

// A descriptor that is closed with its owner.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int file) : file_(file) {}
  Descriptor(Descriptor&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }
  ~Descriptor() { Close(); }
  void Close() {
    if (file_ >= 0) close(std::exchange(file_, -1));
  }
  int get() const { return file_; }

 private:
  int file_ = -1;
};

absl::StatusOr<Descriptor> MemoryFile(const char* name) {
  Descriptor file(memfd_create(name, MFD_CLOEXEC));
  if (file.get() < 0) return SystemError("memfd_create");
  return file;
}

// The loader with `in` as its descriptor 0, `out` as 1 and `reason` as 2, no other, no blocked signal,
// and out of reach of the terminal's. Its memory is taken in huge pages, for the faults of small ones can
// cost more than the reading.
absl::StatusOr<pid_t> Start(const std::string& loader, const std::string& memory, const std::string& cpu, int in,
                            int out, int reason) {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  const std::pair<int, int> files[] = {{in, STDIN_FILENO}, {out, STDOUT_FILENO}, {reason, STDERR_FILENO}};
  for (const auto& [from, to] : files) posix_spawn_file_actions_adddup2(&actions, from, to);
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  std::string name = "halfshade-scene-loader", memory_text = memory, cpu_text = cpu;
  char* const arguments[] = {name.data(), memory_text.data(), cpu_text.data(), nullptr};
  std::string huge_pages = "GLIBC_TUNABLES=glibc.malloc.hugetlb=1";
  char* const environment[] = {huge_pages.data(), nullptr};
  pid_t process = -1;
  const int error = posix_spawn(&process, loader.c_str(), &actions, &attributes, arguments, environment);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) return SystemError("starting " + loader, error);
  return process;
}

// What is said until every writer is gone; false where that takes longer.
bool Listen(int file, SteadyClock::time_point until, std::string* said) {
  char piece[4096];
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - SteadyClock::now()).count();
    if (left <= 0) return false;
    pollfd event = {file, POLLIN, 0};
    if (poll(&event, 1, int(std::min<int64_t>(left, 1 << 30))) <= 0) continue;  // the clock tells
    const ssize_t got = read(file, piece, sizeof(piece));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return true;
    said->append(piece, size_t(got));
    if (said->size() > kMaxReason) said->resize(kMaxReason);
  }
}

absl::StatusOr<std::string> ReadAll(int file) {
  struct stat status {};
  std::string bytes;
  if (fstat(file, &status) != 0 || lseek(file, 0, SEEK_SET) != 0) return SystemError("the answer");
  bytes.resize(size_t(status.st_size));
  if (!ReadWhole(file, bytes.data(), bytes.size())) return SystemError("the answer");
  return bytes;
}

}  // namespace

double Fence::last_cpu_s() { return cpu_s_of_last_task; }

struct Fence::Task {
  std::string place;  // begins the message of what fails
  uint64_t bytes = 0;
  std::function<bool(const ByteSink&)> write;
};

absl::StatusOr<std::string> Fence::Run(const Task& task) const {
  const uint64_t more_s = task.bytes / FenceOptions::kBytesPerSecond;
  const uint64_t cpu_s = options_.cpu_s + more_s, wall_s = options_.wall_s + more_s;
  ASSIGN_OR_RETURN(Descriptor in, MemoryFile("halfshade-task"));
  ASSIGN_OR_RETURN(const Descriptor out, MemoryFile("halfshade-answer"));
  const int file = in.get();
  if (!task.write([file](const void* bytes, size_t size) { return WriteWhole(file, bytes, size); }) ||
      lseek(file, 0, SEEK_SET) != 0) {
    return SystemError("the task");
  }
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return SystemError("pipe");
  const Descriptor reason(ends[0]);
  Descriptor reason_in(ends[1]);
  const auto begin = SteadyClock::now();
  ASSIGN_OR_RETURN(const pid_t process, Start(options_.loader, std::to_string(options_.memory_mb << 20),
                                              std::to_string(cpu_s), file, out.get(), reason_in.get()));
  reason_in.Close();
  in.Close();
  std::string said;
  const bool is_in_time = Listen(reason.get(), begin + std::chrono::seconds(wall_s), &said);
  if (!is_in_time) kill(process, SIGKILL);
  int end = 0;
  struct rusage usage {};
  while (wait4(process, &end, 0, &usage) < 0) {
    if (errno != EINTR) return SystemError("wait4");
  }
  cpu_s_of_last_task = double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
                       1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  const int code = WIFEXITED(end) ? WEXITSTATUS(end) : -1, signal = WIFSIGNALED(end) ? WTERMSIG(end) : 0;
  if (code == kExitAnswered) return ReadAll(out.get());
  spdlog::warn("scene loader: {} {}, after {:.2f} s of CPU time: {}", signal != 0 ? "signal" : "exit code",
               signal != 0 ? signal : code, cpu_s_of_last_task, said);
  const auto too_much = [&](const std::string& what) {
    return absl::ResourceExhaustedError(task.place + ": reading its " + std::to_string(task.bytes) +
                                        " bytes takes more than " + what);
  };
  if (!is_in_time) return too_much(std::to_string(wall_s) + " s");
  // SIGKILL: the system's, where memory or time ran out.
  if (signal == SIGXCPU) return too_much(std::to_string(cpu_s) + " s of CPU time");
  if (signal == SIGXFSZ || signal == SIGKILL || code == kExitNoMemory) {
    return too_much(std::to_string(options_.memory_mb) + " MB of memory");
  }
  if (code == kExitNoFence) return absl::FailedPreconditionError("scene loader: " + said);
  if (code >= 0) return absl::InternalError("scene loader: exit code " + std::to_string(code) + ": " + said);
  return absl::InvalidArgumentError(task.place + ": reading it crashes the scene loader (signal " +
                                    std::to_string(signal) + ")");
}

absl::StatusOr<FlatScene> Fence::Load(const std::string& root, const FileMap& files, const SceneLoadLimits& limits) {
  Task task{"/", root.size(), [&](const ByteSink& sink) { return WriteLoadTask(root, files, limits, sink); }};
  for (const auto& [uri, bytes] : files) task.bytes += bytes->size();
  ASSIGN_OR_RETURN(const std::string answer, Run(task));
  return ReadSceneAnswer(answer);
}

absl::StatusOr<Rgba8Image> Fence::Decode(const EncodedImage& image, uint64_t max_pixels) {
  ASSIGN_OR_RETURN(const std::string answer, Run({image.name, image.bytes.size(), [&](const ByteSink& sink) {
                                                    return WriteDecodeTask(image, max_pixels, sink);
                                                  }}));
  return ReadImageAnswer(answer);
}

absl::StatusOr<std::unique_ptr<Fence>> Fence::Raise(const FenceOptions& options) {
  auto fence = std::unique_ptr<Fence>(new Fence(options));
  const absl::StatusOr<FlatScene> empty = fence->Load(R"({"asset":{"version":"2.0"}})", {}, {});
  if (!empty.ok()) {
    return absl::FailedPreconditionError("the fence does not stand: " + std::string(empty.status().message()));
  }
  return fence;
}

}  // namespace halfshade
