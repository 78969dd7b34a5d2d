// halfshade-scene-loader MEMORY_BYTES CPU_S: one task from descriptor 0, its answer to 1, reasons to 2 (message.h).
// The server starts one for each scene and each image that it reads: what one stranger's bytes break ends with them.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "renderer/scene_loader/fence/confine.h"
#include "renderer/scene_loader/fence/descriptors.h"
#include "renderer/scene_loader/fence/message.h"

int main(int argc, char** argv) {
  using namespace halfshade;
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s MEMORY_BYTES CPU_S; halfshaded starts it\n", argv[0]);
    return kExitUsage;
  }
  const ConfineLimits limits = {std::strtoull(argv[1], nullptr, 10), uint32_t(std::strtoul(argv[2], nullptr, 10))};
  if (const absl::Status status = Confine(limits); !status.ok()) {
    std::fprintf(stderr, "%s\n", std::string(status.message()).c_str());
    return kExitNoFence;
  }
  LoaderTask task;
  if (!ReadTask([](void* bytes, size_t size) { return ReadWhole(STDIN_FILENO, bytes, size); }, &task)) {
    _exit(kExitNoTask);
  }
  const bool is_answered =
      AnswerTask(task, [](const void* bytes, size_t size) { return WriteWhole(STDOUT_FILENO, bytes, size); });
  // Nothing is to run after this: no destructors, no handlers.
  _exit(is_answered ? kExitAnswered : kExitNoTask);
}
