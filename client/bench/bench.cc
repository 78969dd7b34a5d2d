#include "client/bench/bench.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <ctime>

#include "client/bench/reference.h"
#include "client/bench/shot.h"
#include "client/bench/statistics.h"
#include "renderer/image/surface_filter.h"
#include "renderer/status.h"

namespace halfshade::bench {
namespace {

// What filters go by; their time does not count it, as primary visibility.
absl::StatusOr<Surfaces> FetchSurfaces(Client& client, const Case& bench_case) {
  v1::RenderRequest request = bench_case.request;
  request.clear_outputs();
  for (const v1::OutputKind kind : {v1::OUTPUT_KIND_POSITION, v1::OUTPUT_KIND_NORMAL}) {
    v1::Output* output = request.add_outputs();
    output->set_kind(kind);
    output->set_encoding(v1::ENCODING_RAW_F32);
  }
  ASSIGN_OR_RETURN(const v1::RenderResponse response, client.Render(request, nullptr));
  Surfaces surfaces;
  ASSIGN_OR_RETURN(const Image points, RawImage(response.images(0)));
  ASSIGN_OR_RETURN(const Image normals, RawImage(response.images(1)));
  for (int y = 0; y < points.height(); ++y) {
    for (int x = 0; x < points.width(); ++x) {
      surfaces.points.emplace_back(points.at(x, y, 0), points.at(x, y, 1), points.at(x, y, 2));
      surfaces.normals.emplace_back(normals.at(x, y, 0), normals.at(x, y, 1), normals.at(x, y, 2));
    }
  }
  return surfaces;
}

// Filtered, on one thread, where the setting says so; the time is the shot's.
void Filter(const Setting& setting, const Surfaces& surfaces, Shot* shot) {
  if (setting.filter_radius == 0) return;
  const std::clock_t begin = std::clock();
  shot->visibility = FilterAlongSurfaces(shot->visibility, surfaces, setting.filter_radius);
  const double ms = 1000.0 * double(std::clock() - begin) / CLOCKS_PER_SEC;
  v1::Timing* timing = shot->report.mutable_timing();
  timing->set_cpu_ms(timing->cpu_ms() + ms);
  timing->set_total_ms(timing->total_ms() + ms);
  timing->set_resolve_ms(timing->resolve_ms() + ms);
}

double WallMs(const v1::Timing& timing) { return timing.total_ms() - timing.encode_ms() - timing.digest_ms(); }

// What every method pays alike: the G-buffer, asked for by an output that needs no light.
absl::StatusOr<double> PrimaryCpuMs(Client& client, const Case& bench_case, int repetitions) {
  v1::RenderRequest request = bench_case.request;
  request.set_cache(v1::CACHE_MODE_REFRESH);
  request.clear_outputs();
  v1::Output* output = request.add_outputs();
  output->set_kind(v1::OUTPUT_KIND_DEPTH);
  output->set_encoding(v1::ENCODING_RAW_F32);
  std::vector<double> cpu_ms;
  for (int i = 0; i <= repetitions; ++i) {
    ASSIGN_OR_RETURN(const v1::RenderResponse response, client.Render(request, nullptr));
    if (i > 0) cpu_ms.push_back(response.report().timing().cpu_ms());
  }
  return Median(cpu_ms);
}

// Another camera under the same light.
void MoveCamera(int step, v1::RenderRequest* request) {
  if (!request->camera().has_look_at()) return;
  v1::Vec3* eye = request->mutable_camera()->mutable_look_at()->mutable_eye();
  const v1::Vec3& target = request->camera().look_at().target();
  const double share = 1e-3 * step;
  eye->set_x(eye->x() + share * (eye->z() - target.z()));
  eye->set_z(eye->z() - share * (eye->x() - target.x()));
}

struct Samples {
  std::vector<double> cpu_ms, wall_ms, light_ms, resolve_ms, warm_cpu_ms;
  std::vector<std::pair<std::string, std::vector<double>>> steps_ms;
};

void Add(const v1::RenderReport& report, Samples* samples) {
  const v1::Timing& timing = report.timing();
  samples->cpu_ms.push_back(timing.cpu_ms());
  samples->wall_ms.push_back(WallMs(timing));
  samples->light_ms.push_back(timing.light_ms());
  samples->resolve_ms.push_back(timing.resolve_ms());
  constexpr char kStep[] = "resolve/";
  size_t step = 0;
  for (const v1::Pass& pass : report.passes()) {
    const size_t place = pass.name().find(kStep);
    if (place == std::string::npos) continue;
    if (step == samples->steps_ms.size()) {
      samples->steps_ms.push_back({pass.name().substr(place + sizeof kStep - 1), {}});
    }
    samples->steps_ms[step++].second.push_back(pass.ms());
  }
}

uint64_t LightDataBytes(const v1::RenderReport& report) {
  for (const v1::Cache& cache : report.caches()) {
    if (cache.name() == "light[0]/light_data") return cache.bytes();
  }
  return 0;
}

// What the method keeps of the scene, whatever the light.
bool IsOfScene(const std::string& name) { return name == "scene_data" || name == "ray_scene"; }

double SceneDataMs(const v1::RenderReport& report) {
  for (const v1::Pass& pass : report.passes()) {
    if (IsOfScene(pass.name())) return pass.ms();
  }
  return 0;
}

double SceneDataBytes(const v1::RenderReport& report) {
  for (const v1::Cache& cache : report.caches()) {
    if (IsOfScene(cache.name())) return double(cache.bytes());
  }
  return 0;
}

// The warming shot of a row: its error, and what it skips.
absl::Status Judge(const Shot& shot, const CaseResult& result, Row* row) {
  const Image& reference = result.reference;
  ASSIGN_OR_RETURN(row->error, Compare(reference, shot.visibility, &result.mask));
  row->difference = Image(reference.width(), reference.height(), 1);
  for (size_t i = 0; i < reference.size(); ++i) {
    row->difference.data()[i] = shot.visibility.data()[i] - reference.data()[i];
  }
  for (const v1::Pass& pass : shot.report.passes()) {
    if (pass.skipped()) row->skipped.push_back(pass.name() + ": " + pass.reason());
  }
  row->predicted = shot.report.error().predicted();
  row->light_data_bytes = LightDataBytes(shot.report);
  return absl::OkStatus();
}

void MarkFront(std::vector<Row>* rows) {
  std::vector<double> cost, error;
  std::vector<Row*> whole;
  for (Row& row : *rows) {
    if (!row.failure.empty()) continue;
    cost.push_back(row.shadow_cpu_ms);
    error.push_back(row.error.mae_shadowed.value_or(0));
    whole.push_back(&row);
  }
  const std::vector<bool> is_on_front = ParetoFront(cost, error);
  for (size_t i = 0; i < whole.size(); ++i) whole[i]->is_on_front = is_on_front[i];
}

absl::StatusOr<std::string> RenderFrame(Client& client, const Case& bench_case) {
  v1::RenderRequest request = bench_case.request;
  request.mutable_method()->mutable_multi_map()->set_k(64);
  request.clear_outputs();
  request.add_outputs()->set_encoding(v1::ENCODING_PNG);
  ASSIGN_OR_RETURN(const v1::RenderResponse response, client.Render(request, nullptr));
  return response.images(0).data();
}

// What all settings of a step stand against.
struct StepBase {
  double primary_cpu_ms = 0;
  CaseResult truth;  // empty unless errors are measured
};

absl::StatusOr<StepBase> PrepareStep(Client& client, const Case& bench_case, bool measures_error,
                                     const Effort& effort) {
  StepBase base;
  ASSIGN_OR_RETURN(const v1::Scene scene, client.UploadScene(bench_case.files));
  ASSIGN_OR_RETURN(base.primary_cpu_ms, PrimaryCpuMs(client, bench_case, effort.repetitions));
  if (!measures_error) return base;
  RETURN_IF_ERROR(MeasureReference(client, bench_case, scene, effort.reference_rays, &base.truth));
  return base;
}

// Adds a point to each curve that has not failed. Errors come from the shot that warms up.
void MeasureStep(Client& client, const CurvePlan::Step& step, bool measures_error, const Effort& effort,
                 std::vector<Curve>* curves) {
  const auto base = PrepareStep(client, step.bench_case, measures_error, effort);
  std::vector<std::vector<double>> cpu_ms(curves->size()), light_ms(curves->size());
  std::vector<uint64_t> light_bytes(curves->size(), 0);
  std::vector<double> scene_ms(curves->size(), 0), scene_bytes(curves->size(), 0);
  for (int repetition = 0; repetition <= effort.repetitions; ++repetition) {
    for (size_t i = 0; i < curves->size(); ++i) {
      Curve& curve = (*curves)[i];
      if (!curve.failure.empty()) continue;
      const auto measure = [&]() -> absl::Status {
        RETURN_IF_ERROR(base.status());
        ASSIGN_OR_RETURN(const Shot shot,
                         Shoot(client, VisibilityRequest(step.bench_case, step.settings[i], v1::CACHE_MODE_REFRESH)));
        if (repetition > 0) {
          cpu_ms[i].push_back(shot.report.timing().cpu_ms());
          light_ms[i].push_back(shot.report.timing().light_ms());
          light_bytes[i] = LightDataBytes(shot.report);
        }
        if (repetition == 0) {
          scene_ms[i] = SceneDataMs(shot.report);
          scene_bytes[i] = SceneDataBytes(shot.report);
        }
        if (repetition > 0 || !measures_error) return absl::OkStatus();
        ASSIGN_OR_RETURN(const ImageError error, Compare(base->truth.reference, shot.visibility, &base->truth.mask));
        curve.mae_shadowed.push_back(error.mae_shadowed.value_or(0));
        return absl::OkStatus();
      };
      const absl::Status status = measure();
      if (!status.ok()) curve.failure = absl::StrCat(curve.work, " ", step.x, ": ", status.ToString());
    }
  }
  for (size_t i = 0; i < curves->size(); ++i) {
    Curve& curve = (*curves)[i];
    if (!curve.failure.empty()) continue;
    curve.x.push_back(step.x);
    // A cost below the clock's own noise counts as that.
    curve.cpu_ms.push_back(std::max(0.1, Median(cpu_ms[i]) - base->primary_cpu_ms));
    curve.light_ms.push_back(Median(light_ms[i]));
    curve.light_bytes.push_back(double(light_bytes[i]));
    curve.scene_ms.push_back(scene_ms[i]);
    curve.scene_bytes.push_back(scene_bytes[i]);
  }
}

}  // namespace

absl::StatusOr<CaseResult> MeasureCase(Client& client, const Case& bench_case, const std::vector<Setting>& settings,
                                       const Effort& effort, Progress& progress) {
  CaseResult result;
  result.name = bench_case.name;
  result.is_dense = bench_case.is_dense;
  ASSIGN_OR_RETURN(const v1::Scene scene, client.UploadScene(bench_case.files));
  ASSIGN_OR_RETURN(result.frame_png, RenderFrame(client, bench_case));
  ASSIGN_OR_RETURN(result.primary_cpu_ms, PrimaryCpuMs(client, bench_case, effort.repetitions));
  RETURN_IF_ERROR(MeasureReference(client, bench_case, scene, effort.reference_rays, &result));
  Surfaces surfaces;
  if (std::any_of(settings.begin(), settings.end(), [](const Setting& s) { return s.filter_radius > 0; })) {
    ASSIGN_OR_RETURN(surfaces, FetchSurfaces(client, bench_case));
  }
  std::vector<Samples> samples(settings.size());
  for (const Setting& setting : settings) result.rows.emplace_back().setting = setting;
  for (int repetition = 0; repetition <= effort.repetitions; ++repetition) {
    for (size_t i = 0; i < settings.size(); ++i) {
      Row& row = result.rows[i];
      if (!row.failure.empty()) continue;
      progress.Show(bench_case.name.c_str(),
                    double(repetition * settings.size() + i) / double((effort.repetitions + 1) * settings.size()));
      auto cold = Shoot(client, VisibilityRequest(bench_case, settings[i], v1::CACHE_MODE_REFRESH));
      if (!cold.ok()) {
        row.failure = cold.status().ToString();
        continue;
      }
      Filter(settings[i], surfaces, &*cold);
      if (repetition == 0) {
        RETURN_IF_ERROR(Judge(*cold, result, &row));
      } else {
        Add(cold->report, &samples[i]);
      }
      if (!effort.measures_warm) continue;
      v1::RenderRequest moved = VisibilityRequest(bench_case, settings[i], v1::CACHE_MODE_USE);
      MoveCamera(repetition + 1, &moved);
      const auto warm = Shoot(client, moved);
      if (warm.ok() && repetition > 0) samples[i].warm_cpu_ms.push_back(warm->report.timing().cpu_ms());
    }
  }
  for (size_t i = 0; i < settings.size(); ++i) {
    Row& row = result.rows[i];
    if (!row.failure.empty()) continue;
    row.cpu_ms = Median(samples[i].cpu_ms);
    row.wall_ms = Median(samples[i].wall_ms);
    row.light_ms = Median(samples[i].light_ms);
    row.resolve_ms = Median(samples[i].resolve_ms);
    for (const auto& [name, ms] : samples[i].steps_ms) row.steps.push_back({name, Median(ms)});
    row.shadow_cpu_ms = std::max(0.0, row.cpu_ms - result.primary_cpu_ms);
    if (!samples[i].warm_cpu_ms.empty()) row.warm_cpu_ms = Median(samples[i].warm_cpu_ms);
  }
  MarkFront(&result.rows);
  return result;
}

std::vector<Curve> MeasureCurves(Client& client, const CurvePlan& plan, const Effort& effort, Progress& progress) {
  std::vector<Curve> curves;
  for (const Setting& setting : plan.steps.front().settings) {
    Curve& curve = curves.emplace_back();
    curve.work = plan.work;
    curve.setting = setting;
  }
  Effort own_effort = effort;
  if (plan.repetitions > 0) own_effort.repetitions = plan.repetitions;
  for (size_t s = 0; s < plan.steps.size(); ++s) {
    progress.Show(plan.work.c_str(), double(s) / double(plan.steps.size()));
    MeasureStep(client, plan.steps[s], plan.measures_error, own_effort, &curves);
  }
  for (Curve& curve : curves) {
    if (curve.failure.empty() && curve.x.size() > 1) curve.exponent = PowerLawExponent(curve.x, curve.cpu_ms);
  }
  return curves;
}

}  // namespace halfshade::bench
