#include "server/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <chrono>
#include <filesystem>

#include "server/call_time.h"
#include "server/process_memory.h"

namespace halfshade {
namespace {

using prometheus::Histogram;

const Histogram::BucketBoundaries kSeconds = {.001, .002, .005, .01, .02, .05, .1, .2, .5, 1, 2, 5, 10, 30, 60, 600};
const Histogram::BucketBoundaries kErrors = {.0005, .001, .002, .005, .01, .02, .05, .1};

std::string CodeName(absl::StatusCode code) { return absl::StatusCodeToString(code); }

// "light[0]/multi_map" -> "multi_map": how many lights there are is no label.
std::string PassName(const std::string& name) { return name.substr(name.rfind('/') + 1); }

double OpenFiles() {
  std::error_code error;
  const std::filesystem::directory_iterator files("/proc/self/fd", error);
  return error ? 0 : double(std::distance(begin(files), end(files)));
}

// Metrics of other tools' dashboards: names and help are those of Prometheus' own clients.
std::vector<Metrics::Sample> OfTheProcess() {
  static const double start_s =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  return {
      {"process_cpu_seconds_total", "Total user and system CPU time spent in seconds.", true, "", "",
       ProcessCpuMs() / 1e3},
      {"process_resident_memory_bytes", "Resident memory size in bytes.", false, "", "", double(ResidentBytes())},
      {"process_open_fds", "Number of open file descriptors.", false, "", "", OpenFiles()},
      {"process_start_time_seconds", "Start time of the process since unix epoch in seconds.", false, "", "", start_s}};
}

void AddSamples(const std::vector<Metrics::Sample>& samples, std::vector<prometheus::MetricFamily>* families) {
  for (const Metrics::Sample& sample : samples) {
    if (families->empty() || families->back().name != sample.name) {
      const auto type = sample.is_counter ? prometheus::MetricType::Counter : prometheus::MetricType::Gauge;
      families->push_back({sample.name, sample.help, type, {}});
    }
    prometheus::ClientMetric metric;
    if (!sample.label.empty()) metric.label = {{sample.label, sample.label_value}};
    (sample.is_counter ? metric.counter.value : metric.gauge.value) = sample.value;
    families->back().metric.push_back(std::move(metric));
  }
}

}  // namespace

struct Metrics::Families {
  prometheus::Registry registry;
  prometheus::Family<prometheus::Counter>& calls = prometheus::BuildCounter()
                                                       .Name("halfshade_calls_total")
                                                       .Help("Calls that ended, by rpc and status code.")
                                                       .Register(registry);
  prometheus::Family<Histogram>& call_seconds = prometheus::BuildHistogram()
                                                    .Name("halfshade_call_seconds")
                                                    .Help("From a call's arrival to its end.")
                                                    .Register(registry);
  prometheus::Family<prometheus::Counter>& renders = prometheus::BuildCounter()
                                                         .Name("halfshade_renders_total")
                                                         .Help("Renders that ended well, by method.")
                                                         .Register(registry);
  prometheus::Family<Histogram>& stage_seconds = prometheus::BuildHistogram()
                                                     .Name("halfshade_stage_seconds")
                                                     .Help("Wall time of a render's stages.")
                                                     .Register(registry);
  prometheus::Family<prometheus::Counter>& skips = prometheus::BuildCounter()
                                                       .Name("halfshade_skips_total")
                                                       .Help("Passes left out because nothing needed them.")
                                                       .Register(registry);
  prometheus::Family<Histogram>& errors = prometheus::BuildHistogram()
                                              .Name("halfshade_visibility_error")
                                              .Help("Mean abs error of visibility, predicted or measured.")
                                              .Register(registry);
};

Metrics::Metrics() : families_(std::make_unique<Families>()) {}
Metrics::~Metrics() = default;

void Metrics::CountCall(const std::string& rpc, absl::StatusCode code, double seconds) {
  families_->calls.Add({{"rpc", rpc}, {"code", CodeName(code)}}).Increment();
  families_->call_seconds.Add({{"rpc", rpc}, {"code", CodeName(code)}}, kSeconds).Observe(seconds);
}

void Metrics::CountRender(const v1::RenderReport& report) {
  families_->renders.Add({{"method", report.method()}}).Increment();
  const v1::Timing& timing = report.timing();
  const std::pair<const char*, double> stages[] = {
      {"queue", timing.queue_ms()},       {"load", timing.load_ms()},       {"upload", timing.upload_ms()},
      {"light", timing.light_ms()},       {"resolve", timing.resolve_ms()}, {"shade", timing.shade_ms()},
      {"readback", timing.readback_ms()}, {"encode", timing.encode_ms()},   {"digest", timing.digest_ms()}};
  for (const auto& [stage, ms] : stages) {
    families_->stage_seconds.Add({{"stage", stage}}, kSeconds).Observe(ms / 1e3);
  }
  for (const v1::Pass& pass : report.passes()) {
    if (pass.skipped()) families_->skips.Add({{"pass", PassName(pass.name())}}).Increment();
  }
  if (report.error().has_predicted()) {
    families_->errors.Add({{"kind", "predicted"}}, kErrors).Observe(report.error().predicted());
  }
  if (report.error().has_measured()) {
    families_->errors.Add({{"kind", "measured"}}, kErrors).Observe(report.error().measured());
  }
}

std::string Metrics::Text(const std::vector<Sample>& samples) const {
  std::vector<prometheus::MetricFamily> families = families_->registry.Collect();
  AddSamples(samples, &families);
  AddSamples(OfTheProcess(), &families);
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace halfshade
