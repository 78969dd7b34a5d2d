// Where lines go and what they look like: stderr, as text or as one JSON object each.
#pragma once

#include <spdlog/spdlog.h>

#include <memory>
#include <string>

namespace halfshade {

// Once, before threads are started. `level`: trace, debug, info, warn, error, off.
void SetUpLog(const std::string& level, bool is_json);

// How a call ended.
struct CallLine {
  std::string request_id, rpc, peer, traceparent, code, message;
  double ms = 0;
};

// The logger of those lines: SetUpLog's, or the default one where nobody set up any.
std::shared_ptr<spdlog::logger> CallLogger();
void LogCall(spdlog::logger& logger, spdlog::level::level_enum level, const CallLine& line);

// What LogCall writes, for a logger of JSON and for one of text.
std::string ToJsonFields(const CallLine& line);
std::string ToText(const CallLine& line);

}  // namespace halfshade
