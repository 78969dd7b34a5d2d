// Two macros for absl::Status, which Debian's absl does not bring. No other room writes its own.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <utility>

#define HALFSHADE_CONCAT_INNER(a, b) a##b
#define HALFSHADE_CONCAT(a, b) HALFSHADE_CONCAT_INNER(a, b)

// Returns from the enclosing function when `expression`, an absl::Status, is not OK.
#define RETURN_IF_ERROR(expression)                                         \
  do {                                                                      \
    if (absl::Status status_ = (expression); !status_.ok()) return status_; \
  } while (false)

// Assigns the value of an absl::StatusOr to `target` (which may declare a variable), or returns its status.
#define ASSIGN_OR_RETURN(target, expression) \
  ASSIGN_OR_RETURN_IMPL(HALFSHADE_CONCAT(status_or_, __LINE__), target, expression)
#define ASSIGN_OR_RETURN_IMPL(status_or, target, expression) \
  auto status_or = (expression);                             \
  if (!status_or.ok()) return status_or.status();            \
  target = *std::move(status_or)
