// The bench: every method and setting on every scene, error against time, in one process and one run.
//
// The service of this process renders; settings take turns within a repetition, so that drift of the machine meets all
// of them alike. Times are medians: CPU milliseconds of all threads (RenderReport.timing.cpuMs) and wall milliseconds
// (totalMs less encoding and digest). Error is that of visibility against RAY (renderer/image/compare.h).
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "client/client.h"
#include "client/progress.h"
#include "client/scene_files.h"
#include "halfshade/v1/render.pb.h"
#include "renderer/image/compare.h"
#include "renderer/image/image.h"

namespace halfshade::bench {

// One method with its options.
struct Setting {
  std::string method;  // "multi_map"
  std::string label;   // "k=64 map_size=1024"
  v1::Method options;
  double max_error = 0;   // of the budget; 0: none
  std::string family;     // whose curve of error against cost it is a point of: "ray adaptive"
  int filter_radius = 0;  // pixels; of visibility along surfaces, in this process (renderer/image/surface_filter.h)
};

// One scene under one light.
struct Case {
  std::string name;  // "S2 light .20", "spot"
  SceneFiles files;
  v1::RenderRequest request;  // scene, camera, lights, ground, width, height
  // Truth is that of a light which is bright as a Gaussian (GaussianLights in reference.h).
  bool is_gaussian = false;
  bool is_dense = false;               // of more than some 50 k triangles in view: aims of its own (fractions.h)
  std::vector<Setting> settings = {};  // instead of the suite's; empty: those
};

struct Effort {
  int repetitions = 7;  // timed ones; a first one warms up
  uint32_t reference_rays = 4096;
  bool measures_warm = true;  // also with light data kept and the camera moved
};

struct Row {
  Setting setting;
  std::string failure;  // the status where it failed; then nothing below holds
  ImageError error;
  double predicted = 0;  // RenderReport.error.predicted; 0: not told
  double cpu_ms = 0;     // cold: light data and resolve, `cache: REFRESH`
  double wall_ms = 0;
  double shadow_cpu_ms = 0;                           // cpu_ms less the case's primary visibility
  double light_ms = 0;                                // wall, of it
  double resolve_ms = 0;                              // wall, of it
  uint64_t light_data_bytes = 0;                      // of the first light
  double warm_cpu_ms = 0;                             // same light, another camera; 0: not measured
  std::vector<std::pair<std::string, double>> steps;  // wall ms of the resolve's own passes, where it has them
  std::vector<std::string> skipped;                   // "pass: reason"
  bool is_on_front = false;                           // no other row of the case is both cheaper and more exact
  Image difference;                                   // visibility less the reference's
};

struct CaseResult {
  std::string name;
  double primary_cpu_ms = 0;   // primary visibility alone: what all rows share
  double reference_noise = 0;  // mean |a - b| / 2 of its two halves, over shadowed pixels
  double reference_cpu_ms = 0;
  bool is_dense = false;
  Image mask;             // 1 where something is drawn that faces part of the light: what errors are taken over
  Image reference;        // visibility of the first light
  std::string frame_png;  // what the scene looks like
  std::vector<Row> rows;
};

// Renders the case in every setting. A setting that fails is a row; an error comes back where the reference fails.
absl::StatusOr<CaseResult> MeasureCase(Client& client, const Case& bench_case, const std::vector<Setting>& settings,
                                       const Effort& effort, Progress& progress);

// Work that grows in steps. Every step has the same methods in the same order, one a curve: with options of its own
// where the work is an option.
struct CurvePlan {
  struct Step {
    double x = 1;  // the amount
    Case bench_case;
    std::vector<Setting> settings;
  };
  std::string work;  // "triangles", "pixels", ...
  std::vector<Step> steps;
  bool measures_error = false;  // against RAY, at each step
  int repetitions = 0;          // 0: as many as the suite's effort says
};

// Cost, and error if it was measured, against one kind of work.
struct Curve {
  std::string work;
  Setting setting;
  std::string failure;
  std::vector<double> x;
  std::vector<double> cpu_ms;        // shadow cost
  std::vector<double> light_ms;      // wall: light data, of all lights
  std::vector<double> light_bytes;   // light data of the first light; 0: none
  std::vector<double> scene_ms;      // wall: what the method keeps of the scene, 0 where another setting had it made
  std::vector<double> scene_bytes;   // 0: nothing
  double exponent = 0;               // of the power law through them
  std::vector<double> mae_shadowed;  // empty unless measured
};

// At each step the settings take turns. What fails ends its curve, whose `failure` says at which step.
std::vector<Curve> MeasureCurves(Client& client, const CurvePlan& plan, const Effort& effort, Progress& progress);

}  // namespace halfshade::bench
