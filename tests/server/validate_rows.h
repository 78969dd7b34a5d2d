// Requests that differ from a good one in one field, and how each is answered: the table of validate_test.cc.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <string>
#include <vector>

#include "halfshade/v1/render.pb.h"

namespace halfshade {

struct ValidateRow {
  std::string name;
  std::function<void(v1::RenderRequest&)> change;
  absl::StatusCode code;
  std::string message;  // part of it; the field comes first
};

// Of RenderRequest.method.
std::vector<ValidateRow> MethodRows();

}  // namespace halfshade
