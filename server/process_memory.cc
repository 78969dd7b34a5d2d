#include "server/process_memory.h"

#include <unistd.h>

#include <fstream>

#ifdef HALFSHADE_JEMALLOC
#include <jemalloc/jemalloc.h>

// jemalloc reads it as the program starts; MALLOC_CONF of the environment goes before it. Each of hundreds of threads
// keeps freed blocks of 4 KiB at most to itself: of 32 KiB, as by default, a flood of refusals leaves 25 MB more.
const char* malloc_conf = "thp:always,background_thread:true,dirty_decay_ms:1000,muzzy_decay_ms:0,lg_tcache_max:12";
#endif

namespace halfshade {

uint64_t ResidentBytes() {
  uint64_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * uint64_t(sysconf(_SC_PAGESIZE));
}

}  // namespace halfshade
