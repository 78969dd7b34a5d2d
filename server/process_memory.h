// What this process has in memory, and how it gives back what it no longer needs. Linux, glibc. Thread-safe.
#pragma once

#include <cstdint>

namespace halfshade {

uint64_t ResidentBytes();

// Gives freed memory back to the system where it may have piled up: at most once a second, and where more is resident
// than after the last time. The allocator keeps what it was given, for the next to ask; what building a large light
// leaves would stay for good, and the next large thing, of another size, come on top of it. Call it between jobs.
void ReturnFreedMemory();

}  // namespace halfshade
