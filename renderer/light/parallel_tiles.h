// Work of the CPU on tiles, on all threads that this process may use.
#pragma once

#include <absl/status/status.h>

#include <functional>

namespace halfshade {

// Calls work(0) .. work(count - 1), in any order and at the same time, in runs of about 10 ms; between them `stop` is
// asked on the calling thread, and its error comes back. The clock decides about runs, so what comes out must not
// depend on order.
absl::Status ForEachTile(int count, const std::function<void(int)>& work, const std::function<absl::Status()>& stop);

}  // namespace halfshade
