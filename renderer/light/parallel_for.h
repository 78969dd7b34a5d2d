// Work of the CPU on tiles or receivers, on all threads that this process may use.
#pragma once

#include <absl/status/status.h>

#include <functional>

namespace halfshade {

// Calls work(0) .. work(count - 1), in any order and at the same time, `grain` of them in a row on one thread. Every 10
// ms all threads meet and `stop` is asked on the calling thread; its error comes back. The first time it may finish
// what GL has under way; from then on other contexts have the turn (gl/turn.h). The clock decides where the threads
// meet, so what comes out must not depend on order. `threads`: 0 for as many as this process may use.
absl::Status ParallelFor(int count, int grain, const std::function<void(int)>& work,
                         const std::function<absl::Status()>& stop, int threads = 0);

}  // namespace halfshade
