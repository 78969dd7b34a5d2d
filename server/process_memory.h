// What this process has in memory. Linux. Thread-safe.
//
// What links the server allocates by jemalloc (unless sanitizers have an allocator of their own): in huge pages, since
// a picture's maps and images are made anew each time, and a fault for every 4 KiB of them can cost as much as it;
// and freed memory goes back to the system within seconds, whoever is idle: what building a large light leaves would
// else stay for good, and the next large thing, of another size, come on top of it.
#pragma once

#include <cstdint>

namespace halfshade {

uint64_t ResidentBytes();

}  // namespace halfshade
