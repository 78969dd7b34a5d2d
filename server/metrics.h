// What a server counts, in Prometheus' words. Thread-safe.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "halfshade/v1/report.pb.h"

namespace halfshade {

class Metrics {
 public:
  // One value that is read when somebody asks, with one label or none. Samples of one name stand together.
  struct Sample {
    std::string name;
    std::string help;
    bool is_counter = false;  // else a gauge
    std::string label, label_value;
    double value = 0;
  };

  Metrics();
  ~Metrics();

  void CountCall(const std::string& rpc, absl::StatusCode code, double seconds);
  // Of a render that ended well: its stages, method, skips and errors.
  void CountRender(const v1::RenderReport& report);

  // The text format, with `samples` and what the process itself uses.
  std::string Text(const std::vector<Sample>& samples) const;

 private:
  struct Families;
  std::unique_ptr<Families> families_;
};

}  // namespace halfshade
