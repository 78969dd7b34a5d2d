// draw_still METHOD CPUS OUT: draws the stress scene's visibility (StressTest's picture) in a process of its own, so
// that driver, backend and threads can be chosen by its environment. CPUS: how many it may use, 0: all that it has.
// OUT: GL_RENDERER, a newline, the floats. Exit code 0, or 1 with words on stderr.
#include <sched.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/stress/stress_fixture.h"

namespace halfshade {
namespace {

bool UseCpus(int count) {
  cpu_set_t all, some;
  if (sched_getaffinity(0, sizeof(all), &all) != 0 || CPU_COUNT(&all) < count) return false;
  CPU_ZERO(&some);
  for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&some) < count; ++cpu) {
    if (CPU_ISSET(cpu, &all)) CPU_SET(cpu, &some);
  }
  return sched_setaffinity(0, sizeof(some), &some) == 0;
}

int Draw(const std::string& name, const std::string& kind, const std::string& path) {
  for (const TestMethod& method : TestMethods()) {
    if (method.name != name) continue;
    const Image v = kind == "points" ? QueryStill(method.options) : DrawStill(method.options);
    std::ofstream file(path, std::ios::binary);
    file << TestContext().renderer() << "\n";
    file.write(reinterpret_cast<const char*>(v.data()), std::streamsize(v.size() * sizeof(float)));
    file.close();
    return v.size() > 0 && file ? 0 : 1;
  }
  std::fprintf(stderr, "draw_still: no method %s\n", name.c_str());
  return 1;
}

}  // namespace
}  // namespace halfshade

int main(int argc, char** argv) {
  if (argc != 5) return 1;
  const int cpus = std::atoi(argv[3]);
  if (cpus > 0 && !halfshade::UseCpus(cpus)) {
    std::fprintf(stderr, "draw_still: cannot use %d CPUs\n", cpus);
    return 1;
  }
  return halfshade::Draw(argv[1], argv[2], argv[4]);
}
