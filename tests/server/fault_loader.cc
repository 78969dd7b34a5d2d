// A scene loader behind the real fence that does what the root of its task tells it: what a stranger's bytes might do
// to the real one. Anything else it answers as the real one would.
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "renderer/scene_loader/fence/confine.h"
#include "renderer/scene_loader/fence/descriptors.h"
#include "renderer/scene_loader/fence/message.h"

namespace halfshade {
namespace {

constexpr char kEmptyScene[] = R"({"asset":{"version":"2.0"}})";

bool Write(const void* bytes, size_t size) { return WriteWhole(STDOUT_FILENO, bytes, size); }

void Burn(double cpu_s) {
  while (double(clock()) / CLOCKS_PER_SEC < cpu_s) {
  }
}

// Whether the task goes on after the fault.
bool Misbehave(const std::string& what, uint64_t amount) {
  if (what == "crash") *static_cast<volatile int*>(nullptr) = 0;
  if (what == "abort") std::abort();
  if (what == "loop") Burn(1e9);
  if (what == "burn_ms") Burn(1e-3 * double(amount));
  if (what == "allocate_mb") {
    static std::vector<char> block;
    block.assign(amount << 20, 'x');
  }
  if (what == "open" && open("/etc/passwd", O_RDONLY) >= 0) Write("opened", 6);
  if (what == "create" && open("/tmp/halfshade_fault", O_WRONLY | O_CREAT, 0600) >= 0) Write("opened", 6);
  if (what == "socket" && socket(AF_INET, SOCK_STREAM, 0) >= 0) Write("opened", 6);
  if (what == "fork" && fork() >= 0) Write("opened", 6);
  if (what == "execute" && execl("/bin/true", "true", nullptr) == 0) Write("opened", 6);
  if (what == "code" && mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED) {
    Write("opened", 6);
  }
  if (what == "kill" && kill(getppid(), 0) == 0) Write("opened", 6);
  if (what == "stop") raise(SIGSTOP);
  if (what == "exit") _exit(int(amount));
  if (what == "nonsense") return !Write("\0\0\0\0 no scene", 13);
  if (what == "silence") return false;
  if (what == "talk") {
    const std::string words(amount, 'w');
    WriteWhole(STDERR_FILENO, words.data(), words.size());
    std::abort();
  }
  if (what == "answer_mb") {
    const std::string piece(1 << 20, 'x');
    for (; amount > 0; --amount) Write(piece.data(), piece.size());
    return false;
  }
  return true;
}

}  // namespace
}  // namespace halfshade

int main(int argc, char** argv) {
  using namespace halfshade;
  if (argc != 3) return kExitUsage;
  if (!Confine({std::strtoull(argv[1], nullptr, 10), uint32_t(std::strtoul(argv[2], nullptr, 10))}).ok()) {
    return kExitNoFence;
  }
  LoaderTask task;
  if (!ReadTask([](void* bytes, size_t size) { return ReadWhole(STDIN_FILENO, bytes, size); }, &task)) _exit(74);
  std::string& root = task.texts[0];
  const size_t colon = root.find(':');
  if (!root.starts_with('{') && !root.starts_with("glTF")) {
    const uint64_t amount = colon == std::string::npos ? 0 : std::strtoull(root.c_str() + colon + 1, nullptr, 10);
    if (!Misbehave(root.substr(0, colon), amount)) _exit(kExitAnswered);
    root = kEmptyScene;
  }
  _exit(AnswerTask(task, Write) ? kExitAnswered : kExitNoTask);
}
