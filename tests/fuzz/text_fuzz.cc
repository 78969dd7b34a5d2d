// A view file, and the manifest of a scene.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>

#include "client/view_file.h"
#include "server/digest.h"
#include "server/scene_name.h"
#include "tests/fuzz/flat_scene_use.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace halfshade;
  const int file = memfd_create("view", MFD_CLOEXEC);
  Require(file >= 0 && write(file, data, size) == ssize_t(size));
  v1::RenderRequest request;
  const absl::Status status = ApplyViewFile("/proc/self/fd/" + std::to_string(file), &request);
  Require(status.ok() || absl::IsInvalidArgument(status));
  close(file);

  const std::string text(reinterpret_cast<const char*>(data), size);
  std::string root;
  std::map<std::string, std::string> files;
  if (ParseSceneManifest(text, &root, &files)) {
    Require(IsSha256Hex(root) && SceneManifest(root, files) == text);
  }
  return 0;
}
