// The passes of one call, timed into its report.
#pragma once

#include <absl/status/status.h>

#include <chrono>
#include <string>

#include "renderer/gl/draw_context.h"
#include "renderer/report.h"
#include "renderer/status.h"

namespace halfshade {

class Stopwatch {
 public:
  double Milliseconds() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

inline PassReport SkippedPass(const std::string& name, const std::string& reason) {
  return {.name = name, .is_skipped = true, .reason = reason};
}

// Runs one pass, waits for its drawing, and books its wall time in a line of its own and in *stage_ms (of the report).
// While it runs its line is the report's last.
template <typename Pass>
absl::Status TimedPass(const DrawContext& draw, RenderReport& report, const std::string& name, double* stage_ms,
                       Pass pass) {
  const Stopwatch stopwatch;
  report.passes.push_back({.name = name});
  const size_t index = report.passes.size() - 1;
  RETURN_IF_ERROR(pass());
  RETURN_IF_ERROR(draw.pacer->Finish());
  report.passes[index].ms = stopwatch.Milliseconds();
  *stage_ms += report.passes[index].ms;
  return absl::OkStatus();
}

}  // namespace halfshade
