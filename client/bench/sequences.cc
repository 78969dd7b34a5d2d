#include "client/bench/sequences.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <random>
#include <utility>

#include "client/bench/reference.h"
#include "client/bench/shot.h"
#include "client/bench/statistics.h"
#include "renderer/status.h"

namespace halfshade::bench {
namespace {

constexpr int kReplies = 21;
constexpr double kOrbitStep = 6 * M_PI / 180;

double WithoutEncoding(const v1::Timing& timing) { return timing.total_ms() - timing.encode_ms() - timing.digest_ms(); }

// The camera turned around its target's upright axis, and lifted.
void TurnCamera(double angle, double lift, v1::RenderRequest* request) {
  v1::LookAt* look_at = request->mutable_camera()->mutable_look_at();
  const double x = look_at->eye().x() - look_at->target().x(), z = look_at->eye().z() - look_at->target().z();
  look_at->mutable_eye()->set_x(look_at->target().x() + std::cos(angle) * x + std::sin(angle) * z);
  look_at->mutable_eye()->set_z(look_at->target().z() - std::sin(angle) * x + std::cos(angle) * z);
  look_at->mutable_eye()->set_y(look_at->target().y() + lift * (look_at->eye().y() - look_at->target().y()));
}

SequencePlan StartPlan(const char* what, const Case& bench_case) {
  SequencePlan plan;
  plan.name = absl::StrCat(bench_case.name, ", ", what);
  plan.files = bench_case.files;
  return plan;
}

void JudgeThree(SequencePlan* plan) {
  const size_t count = plan->frames.size();
  plan->judged = {0, count / 3, 2 * count / 3};
}

// What is asked of each frame: visibility, as AUTO gives it.
v1::RenderRequest FrameRequest(const Case& bench_case) {
  v1::RenderRequest request = VisibilityRequest(bench_case, v1::Method(), v1::CACHE_MODE_USE);
  request.clear_method();
  request.mutable_budget()->set_max_error(0.01);
  return request;
}

// Mean |error| over shadowed pixels, against rays.
absl::StatusOr<double> ErrorOf(Client& client, const SequencePlan& plan, size_t frame, const v1::Scene& scene,
                               const Image& tested) {
  Case bench_case{.name = plan.name, .files = plan.files, .request = plan.frames[frame]};
  bench_case.request.clear_budget();
  CaseResult truth;
  RETURN_IF_ERROR(MeasureReference(client, bench_case, scene, plan.reference_rays, &truth));
  ASSIGN_OR_RETURN(const ImageError error, Compare(truth.reference, tested, &truth.mask));
  return error.mae_shadowed.value_or(0);
}

// Figures are no reasons of their own.
std::string WithoutFigures(const std::string& reason) {
  std::string text;
  for (const char c : reason) {
    const bool is_digit = absl::ascii_isdigit(static_cast<unsigned char>(c));
    if (!is_digit) text += c;
    if (is_digit && !text.ends_with('N')) text += 'N';
  }
  return text;
}

}  // namespace

std::vector<Skip> CountSkips(const std::vector<v1::RenderReport>& reports) {
  std::map<std::string, std::vector<double>> drawn_ms;
  std::map<std::pair<std::string, std::string>, int> skipped;
  for (const v1::RenderReport& report : reports) {
    for (const v1::Pass& pass : report.passes()) {
      if (pass.skipped()) {
        ++skipped[{pass.name(), WithoutFigures(pass.reason())}];
      } else {
        drawn_ms[pass.name()].push_back(pass.ms());
      }
    }
  }
  std::vector<Skip> skips;
  for (const auto& [what, count] : skipped) {
    Skip& skip = skips.emplace_back(Skip{what.first, what.second, double(count) / double(reports.size())});
    if (const auto drawn = drawn_ms.find(what.first); drawn != drawn_ms.end()) skip.saved_ms = Median(drawn->second);
  }
  return skips;
}

std::optional<double> LitTiles(const std::vector<v1::RenderReport>& reports) {
  double sum = 0;
  int count = 0;
  for (const v1::RenderReport& report : reports) {
    for (const v1::Pass& pass : report.passes()) {
      unsigned long lit = 0, others = 0;
      constexpr char kNote[] = "%lu tiles lit: nothing in their shafts; polygons of blocks in %lu";
      if (std::sscanf(pass.reason().c_str(), kNote, &lit, &others) != 2 || lit + others == 0) continue;
      sum += double(lit) / double(lit + others);
      ++count;
    }
  }
  return count > 0 ? std::optional(sum / count) : std::nullopt;
}

SequenceResult MeasureSequence(Client& client, const SequencePlan& plan, Progress& progress) {
  SequenceResult result;
  result.name = plan.name;
  const auto measure = [&]() -> absl::Status {
    ASSIGN_OR_RETURN(const v1::Scene scene, client.UploadScene(plan.files));
    std::vector<v1::RenderReport> reports;
    std::vector<double> later_ms, later_cpu_ms;
    std::vector<std::pair<size_t, Image>> to_judge;
    for (size_t i = 0; i < plan.frames.size(); ++i) {
      progress.Show(plan.name.c_str(), double(i) / double(plan.frames.size()));
      v1::RenderRequest request = plan.frames[i];
      if (i == 0) request.set_cache(v1::CACHE_MODE_REFRESH);
      ASSIGN_OR_RETURN(Shot shot, Shoot(client, request));
      const double ms = WithoutEncoding(shot.report.timing()), cpu_ms = shot.report.timing().cpu_ms();
      if (i == 0) {
        result.first_ms = ms;
        result.first_cpu_ms = cpu_ms;
      } else {
        later_ms.push_back(ms);
        later_cpu_ms.push_back(cpu_ms);
      }
      if (std::find(plan.judged.begin(), plan.judged.end(), i) != plan.judged.end()) {
        result.predicted += shot.report.error().predicted() / double(plan.judged.size());
        to_judge.emplace_back(i, std::move(shot.visibility));
      }
      reports.push_back(std::move(shot.report));
    }
    result.later_ms = Median(later_ms);
    result.later_cpu_ms = Median(later_cpu_ms);
    for (const auto& [i, tested] : to_judge) {
      ASSIGN_OR_RETURN(const double error, ErrorOf(client, plan, i, scene, tested));
      result.error += error / double(to_judge.size());
    }
    result.lit_tiles = LitTiles(reports);
    result.skips = CountSkips(reports);
    return absl::OkStatus();
  };
  if (const absl::Status status = measure(); !status.ok()) result.failure = status.ToString();
  return result;
}

absl::StatusOr<ReplyTimes> MeasureReplies(Client& client, const Case& bench_case) {
  RETURN_IF_ERROR(client.UploadScene(bench_case.files).status());
  ReplyTimes times;
  times.name = bench_case.name;
  v1::RenderRequest request = FrameRequest(bench_case);
  request.mutable_budget()->set_max_error(0.002);
  v1::PlanRenderRequest plan;
  *plan.mutable_request() = request;
  std::vector<double> plan_ms, repeated_ms;
  for (int i = 0; i < kReplies; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    RETURN_IF_ERROR(client.PlanRender(plan, nullptr).status());
    plan_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  }
  times.plan_ms = Median(plan_ms);
  request.set_cache(v1::CACHE_MODE_REFRESH);
  ASSIGN_OR_RETURN(const v1::RenderResponse whole, client.Render(request, nullptr, [&](v1::RenderResponse coarse) {
    if (times.first_image_ms == 0) times.first_image_ms = coarse.report().timing().total_ms();
  }));
  times.whole_ms = whole.report().timing().total_ms();
  if (times.first_image_ms == 0) times.first_image_ms = times.whole_ms;
  request.set_cache(v1::CACHE_MODE_USE);
  for (int i = 0; i <= kReplies; ++i) {
    ASSIGN_OR_RETURN(const v1::RenderResponse again, client.Render(request, nullptr));
    if (i > 0) repeated_ms.push_back(again.report().timing().total_ms());
  }
  times.repeated_ms = Median(repeated_ms);
  return times;
}

SequencePlan DragLight(const Case& bench_case, int frames) {
  SequencePlan plan = StartPlan("light dragged", bench_case);
  for (int i = 0; i < frames; ++i) {
    v1::RenderRequest& frame = plan.frames.emplace_back(FrameRequest(bench_case));
    v1::AreaLight* light = frame.mutable_lights(0);
    const double steps = 0.05 * (i - frames / 2);
    light->mutable_center()->set_x(light->center().x() + steps * light->edge_u().x());
    light->mutable_center()->set_y(light->center().y() + steps * light->edge_u().y());
    light->mutable_center()->set_z(light->center().z() + steps * light->edge_u().z());
  }
  JudgeThree(&plan);
  return plan;
}

SequencePlan OrbitCamera(const Case& bench_case, int frames) {
  SequencePlan plan = StartPlan("camera orbited", bench_case);
  for (int i = 0; i < frames; ++i) TurnCamera(kOrbitStep * i, 1, &plan.frames.emplace_back(FrameRequest(bench_case)));
  JudgeThree(&plan);
  return plan;
}

SequencePlan ScatterCameras(const Case& bench_case, int frames) {
  SequencePlan plan = StartPlan("views at random", bench_case);
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  for (int i = 0; i < frames; ++i) {
    v1::RenderRequest& frame = plan.frames.emplace_back(FrameRequest(bench_case));
    TurnCamera(uniform(0, 2 * M_PI), uniform(0.5, 1.5), &frame);
    // One in four looks elsewhere: past what casts.
    v1::LookAt* look_at = frame.mutable_camera()->mutable_look_at();
    if (i % 4 == 3) look_at->mutable_target()->set_x(look_at->target().x() + uniform(-3, 3));
    v1::Output* depth = frame.add_outputs();
    depth->set_kind(v1::OUTPUT_KIND_DEPTH);
    depth->set_encoding(v1::ENCODING_RAW_F32);
  }
  JudgeThree(&plan);
  return plan;
}

std::string ToTable(const std::vector<SequenceResult>& sequences, const std::vector<ReplyTimes>& replies) {
  std::string text;
  for (const SequenceResult& result : sequences) {
    absl::StrAppend(&text, "\n", result.name, ": ");
    if (!result.failure.empty()) {
      absl::StrAppend(&text, result.failure, "\n");
      continue;
    }
    absl::StrAppendFormat(&text, "first %.1f ms (%.1f CPU), later %.1f (%.1f) a frame, error %.5f, predicted %.5f",
                          result.first_ms, result.first_cpu_ms, result.later_ms, result.later_cpu_ms, result.error,
                          result.predicted);
    if (result.lit_tiles) absl::StrAppendFormat(&text, "; %.0f %% of tiles lit", 100 * *result.lit_tiles);
    absl::StrAppendFormat(&text, "\n  %-24s %8s %9s  %s\n", "left out", "requests", "saved ms", "why");
    for (const Skip& skip : result.skips) {
      absl::StrAppendFormat(&text, "  %-24s %6.0f %% %9s  %s\n", skip.pass, 100 * skip.share,
                            skip.saved_ms ? absl::StrFormat("%.1f", *skip.saved_ms) : "-", skip.reason);
    }
  }
  for (const ReplyTimes& times : replies) {
    absl::StrAppendFormat(
        &text, "\n%s, max_error .002: PlanRender %.2f ms; first image %.1f ms of %.1f; asked again %.2f ms\n",
        times.name, times.plan_ms, times.first_image_ms, times.whole_ms, times.repeated_ms);
  }
  return text;
}

}  // namespace halfshade::bench
