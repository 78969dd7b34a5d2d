// For people: what each form of construction costs, without depth passes, and what compression leaves.
//   pdsm_rate [k] [map_size] [pdsm_size]
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "renderer/shadow/pdsm/event_builder.h"
#include "renderer/shadow/pdsm/slice_builder.h"
#include "tests/renderer/shadow/pdsm/made_maps.h"

namespace halfshade::pdsm {
namespace {

double CpuMs() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return double(now.tv_sec) * 1e3 + double(now.tv_nsec) * 1e-6;
}

void Report(const char* name, const MadeOccluders& occluders, int k, int map_size, int pdsm_size) {
  const MadeMaps made = DrawMaps(occluders, k, map_size, pdsm_size);
  std::printf("%s, light %.2f: k %d, maps %d (%d used), PDSM %d, %d map texels a ray\n", name, occluders.light_m, k,
              map_size, made.grid.map_size, made.grid.size, made.grid.map_texels);
  for (const EventForm form : {EventForm::kTraversal, EventForm::kScatter}) {
    const double start = CpuMs();
    EventBuilder builder(made.grid, form);
    for (const SampleMap& map : made.maps) {
      if (!builder.Add(map).ok()) std::printf("too many events\n");
    }
    const double added = CpuMs();
    const EventBuilder::Result result = *builder.Finish({.eps = 0.01f});
    std::printf("  %-10s %7.0f + %5.0f CPU-ms; events %.1f mean %u most\n",
                form == EventForm::kTraversal ? "TRAVERSAL" : "SCATTER", added - start, CpuMs() - added,
                result.raw.mean, result.raw.most);
    const FunctionCounts counts = CountVertices(result.functions);
    std::printf("             .01: %.1f mean %u most, %.1f MB\n", counts.mean, counts.most,
                double(result.functions.SizeBytes()) * 1e-6);
  }
  for (const float eps : {0.02f, 0.04f}) {
    EventBuilder builder(made.grid, EventForm::kScatter);
    for (const SampleMap& map : made.maps) {
      if (!builder.Add(map).ok()) std::printf("too many events\n");
    }
    const AttenuationFunctions functions = builder.Finish({.eps = eps})->functions;
    const FunctionCounts counts = CountVertices(functions);
    std::printf("             %.2f: %.1f mean %u most, %.1f MB\n", double(eps), counts.mean, counts.most,
                double(functions.SizeBytes()) * 1e-6);
  }
  for (const int slices : {16, 32, 64}) {
    const double start = CpuMs();
    SliceBuilder builder(made.grid, SpaceSlices(slices, 0.6).Depths());
    for (const SampleMap& map : made.maps) builder.Add(map);
    const SliceVolume volume = builder.Finish();
    std::printf("  SLICES %2d  %7.0f CPU-ms, %.1f MB\n", slices, CpuMs() - start, double(volume.SizeBytes()) * 1e-6);
  }
}

}  // namespace
}  // namespace halfshade::pdsm

int main(int argc, char** argv) {
  const int k = argc > 1 ? std::atoi(argv[1]) : 64;
  const int map_size = argc > 2 ? std::atoi(argv[2]) : 512;
  const int pdsm_size = argc > 3 ? std::atoi(argv[3]) : 512;
  namespace pdsm = halfshade::pdsm;
  pdsm::MadeOccluders sphere;
  sphere.spheres = {{{0.1, 0, 0.8}, 0.4}};
  for (const double light : {0.2, 0.5}) {
    sphere.light_m = light;
    pdsm::Report("sphere", sphere, k, map_size, pdsm_size);
    pdsm::Report("60 spheres", pdsm::Clutter(60, 1, light), k, map_size, pdsm_size);
  }
}
