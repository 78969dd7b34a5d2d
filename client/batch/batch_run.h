// Renders the items of a batch, several at a time, each stored as it is finished.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "client/batch/batch_file.h"
#include "client/client.h"

namespace halfshade {

struct BatchOptions {
  std::string folder;
  int jobs = 4;              // calls in flight
  bool keeps_going = false;  // after an item's failure: else none is begun then, those in flight are finished
};

struct BatchProgress {
  size_t done = 0;  // rendered, or failed
  size_t total = 0;
  double elapsed_s = 0;
};

// Renders `items` by scene and light in their order, with several servers as many scenes at a time; a scene that is a
// path is uploaded where a server lacks it. `scene_names`: of each item's scene. Blocks until all is done; the
// failures, in the order in which they happened. A server that is gone, a folder that cannot be written and a refused
// caller are nobody's own: they end the run even where it keeps going. `progress` is called from many threads, one at a
// time.
std::vector<BatchFailure> RunItems(Client* client, const BatchFile& batch, const std::vector<BatchItem>& items,
                                   const std::map<std::string, std::string>& scene_names, const BatchOptions& options,
                                   const std::function<void(const BatchProgress&)>& progress);

}  // namespace halfshade
