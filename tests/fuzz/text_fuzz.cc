// A view file, a batch, and the manifest of a scene.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <set>

#include "client/batch/batch_file.h"
#include "client/view_file.h"
#include "server/digest.h"
#include "server/scene_name.h"
#include "tests/fuzz/flat_scene_use.h"

namespace {

using namespace halfshade;

// Every line that is not blank is an item or a failure, and an item's text is what it was read from.
void UseBatch(const BatchFile& batch) {
  std::set<std::string> ids;
  for (const BatchItem& item : batch.items) {
    Require(ids.insert(item.id).second);
    const auto line = ReadBatchLine(batch.TextOf(item), batch.folder);
    Require(line.ok() && line->id == item.id && line->request.scene() == item.scene && ItemFileNames(*line).ok());
  }
  for (const BatchFailure& failure : batch.failures) Require(absl::IsInvalidArgument(failure.status));
  size_t lines = 0;
  for (size_t begin = 0; begin < batch.text.size();) {
    const size_t end = std::min(batch.text.find('\n', begin), batch.text.size());
    const size_t word = batch.text.find_first_not_of(" \t\r", begin);
    if (word < end) ++lines;
    begin = end + 1;
  }
  Require(batch.items.size() + batch.failures.size() == lines);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const int file = memfd_create("view", MFD_CLOEXEC);
  Require(file >= 0 && write(file, data, size) == ssize_t(size));
  const std::string path = "/proc/self/fd/" + std::to_string(file);
  v1::RenderRequest request;
  const absl::Status status = ApplyViewFile(path, &request);
  Require(status.ok() || absl::IsInvalidArgument(status));
  const auto batch = ReadBatchFile(path);
  Require(batch.ok());
  UseBatch(*batch);
  close(file);

  const std::string text(reinterpret_cast<const char*>(data), size);
  std::string root;
  std::map<std::string, std::string> files;
  if (ParseSceneManifest(text, &root, &files)) {
    Require(IsSha256Hex(root) && SceneManifest(root, files) == text);
  }
  return 0;
}
