// halfshade bench
#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "client/bench/page.h"
#include "client/bench/suites.h"
#include "client/bench/tables.h"
#include "client/exit_code.h"
#include "client/output_file.h"
#include "client/session.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

std::string CpuModel() {
  std::ifstream cpus("/proc/cpuinfo");
  for (std::string line; std::getline(cpus, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

bench::Head MakeHead(const v1::GetServerInfoResponse& info, const bench::Suite& suite) {
  const char* gl_threads = std::getenv("LP_NUM_THREADS");
  return {{"cpu", absl::StrCat(CpuModel(), ", ", std::thread::hardware_concurrency(), " cores")},
          {"gl", absl::StrCat(info.contexts(0).gl_renderer(), ", ", info.contexts(0).gl_version())},
          {"gl threads", gl_threads == nullptr ? "the driver's choice" : gl_threads},
          {"size", absl::StrCat(suite.cases[0].request.width(), "x", suite.cases[0].request.height())},
          {"reference", absl::StrCat("ray, ", suite.effort.reference_rays, " rays a pixel in two halves")},
          {"times", absl::StrCat("medians of ", suite.effort.repetitions, ", settings in turns")},
          {"build", absl::StrCat("halfshade ", info.version(), ", " HALFSHADE_BUILD_TYPE)},
          {"date", absl::FormatTime("%Y-%m-%d", absl::Now(), absl::UTCTimeZone())}};
}

absl::Status WriteResults(const bench::Results& results, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return CannotWriteError(absl::StrCat(folder, ": ", error.message()));
  ASSIGN_OR_RETURN(const std::string html, bench::ToHtml(results));
  return WriteOutputFiles({{folder + "/bench.csv", bench::ToCsv(results)},
                           {folder + "/bench.json", bench::ToJsonText(results)},
                           {folder + "/bench.txt", bench::ToTable(results)},
                           {folder + "/index.html", html}});
}

absl::StatusOr<bench::Suite> ChooseSuite(const BenchCommand& command, const v1::GetServerInfoResponse& info) {
  const std::vector<std::string> methods(info.methods().begin(), info.methods().end());
  if (!command.scenes.empty()) return bench::MakeSceneSuite(command.scenes, methods);
  if (command.suite == "smoke") return bench::MakeSmokeSuite(methods);
  const char* data = std::getenv("HALFSHADE_TEST_DATA");
  return bench::MakeSuite(command.suite, methods, data == nullptr ? "" : data);
}

}  // namespace

absl::Status RunBench(const GlobalFlags& global, const BenchCommand& command) {
  if (!global.servers.empty()) return UsageError("bench: measures the service of this process; --server is not for it");
  ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(global));
  Client& client = session->client();
  ASSIGN_OR_RETURN(const v1::GetServerInfoResponse info, client.GetServerInfo(client.servers()[0]));
  ASSIGN_OR_RETURN(const bench::Suite suite, ChooseSuite(command, info));
  bench::Results results;
  results.head = MakeHead(info, suite);
  results.judged = suite.judged;
  for (const bench::Case& bench_case : suite.cases) {
    const auto& settings = bench_case.settings.empty() ? suite.settings : bench_case.settings;
    ASSIGN_OR_RETURN(bench::CaseResult result,
                     bench::MeasureCase(client, bench_case, settings, suite.effort, session->progress()));
    results.cases.push_back(std::move(result));
  }
  for (const bench::CurvePlan& plan : suite.curves) {
    for (bench::Curve& curve : bench::MeasureCurves(client, plan, suite.effort, session->progress())) {
      results.curves.push_back(std::move(curve));
    }
  }
  for (const bench::SequencePlan& plan : suite.sequences) {
    results.sequences.push_back(bench::MeasureSequence(client, plan, session->progress()));
  }
  for (const bench::Case& bench_case : suite.replies) {
    ASSIGN_OR_RETURN(results.replies.emplace_back(), bench::MeasureReplies(client, bench_case));
  }
  RETURN_IF_ERROR(WriteResults(results, command.folder));
  session->progress().Say(absl::StrCat(command.folder, "/index.html: ", results.cases.size(), " cases"));
  return Print(global.wants_json ? bench::ToJsonText(results) : bench::ToTable(results));
}

}  // namespace halfshade
