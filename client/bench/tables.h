// The bench's results as text: a table for people, CSV and JSON for programs. Pure.
#pragma once

#include <string>
#include <vector>

#include "client/bench/bench.h"
#include "client/bench/sequences.h"

namespace halfshade::bench {

// The machine and build that the times belong to, as (name, value) lines.
using Head = std::vector<std::pair<std::string, std::string>>;

struct Results {
  Head head;
  std::vector<CaseResult> cases;
  std::vector<Curve> curves;
  std::string judged;  // the method whose cost stands beside the cheapest rival's (fractions.h); empty: none
  std::vector<SequenceResult> sequences = {};
  std::vector<ReplyTimes> replies = {};
};

// Per case: settings from cheap to dear, a mark at those that none beats in both cost and error.
std::string ToTable(const Results& results);
// One line per case and setting, failed ones included; a header line.
std::string ToCsv(const Results& results);
std::string ToJsonText(const Results& results);

}  // namespace halfshade::bench
