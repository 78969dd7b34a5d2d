#include <sched.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "renderer/gl/context.h"

namespace halfshade::gl {
namespace {

// CPUs of the cgroup's quota ("max 100000" or "150000 100000"), or a large number without one.
double CgroupCpus() {
  std::ifstream file("/sys/fs/cgroup/cpu.max");
  std::string quota;
  double period = 0;
  if (!(file >> quota >> period) || quota == "max" || period <= 0) return 1e9;
  return std::atof(quota.c_str()) / period;
}

}  // namespace

int AvailableCpus() {
  cpu_set_t cpus;
  const int affinity = sched_getaffinity(0, sizeof(cpus), &cpus) == 0 ? CPU_COUNT(&cpus) : 1;
  return std::max(1, int(std::min<double>(affinity, CgroupCpus())));
}

void LimitDriverThreads(int contexts) {
  const int threads = std::max(1, AvailableCpus() / std::max(1, contexts));
  setenv("LP_NUM_THREADS", std::to_string(threads).c_str(), /*overwrite=*/0);
}

}  // namespace halfshade::gl
