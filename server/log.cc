#include "server/log.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_sinks.h>

#include <nlohmann/json.hpp>

namespace halfshade {
namespace {

constexpr char kServerName[] = "halfshaded";
constexpr char kCallName[] = "calls";  // in JSON alone: its payloads are fields

std::string Quote(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// {"time":"2026-11-25T06:30:00.123+0000","level":"info","message":"..."}, or the payload's own fields after the level.
class JsonFormatter final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    time_.format(message, out);
    const std::string payload(message.payload.data(), message.payload.size());
    const bool has_fields = std::string_view(message.logger_name.data(), message.logger_name.size()) == kCallName;
    const std::string rest = (has_fields ? payload : absl::StrCat("\"message\":", Quote(payload))) + "}\n";
    out.append(rest.data(), rest.data() + rest.size());
  }
  std::unique_ptr<spdlog::formatter> clone() const override { return std::make_unique<JsonFormatter>(); }

 private:
  spdlog::pattern_formatter time_{"{\"time\":\"%Y-%m-%dT%H:%M:%S.%e%z\",\"level\":\"%l\",",
                                  spdlog::pattern_time_type::utc, ""};
};

}  // namespace

void SetUpLog(const std::string& level, bool is_json) {
  const auto sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
  const auto logger = std::make_shared<spdlog::logger>(kServerName, sink);
  if (is_json) sink->set_formatter(std::make_unique<JsonFormatter>());
  spdlog::set_default_logger(logger);
  if (is_json) spdlog::register_logger(std::make_shared<spdlog::logger>(kCallName, sink));
  spdlog::set_level(spdlog::level::from_str(level == "warn" ? "warning" : level));
}

std::shared_ptr<spdlog::logger> CallLogger() {
  const auto calls = spdlog::get(kCallName);
  return calls != nullptr ? calls : spdlog::default_logger();
}

void LogCall(spdlog::logger& logger, spdlog::level::level_enum level, const CallLine& line) {
  logger.log(level, "{}", logger.name() == kCallName ? ToJsonFields(line) : ToText(line));
}

std::string ToJsonFields(const CallLine& line) {
  std::string fields = absl::StrCat("\"request_id\":", Quote(line.request_id), ",\"rpc\":", Quote(line.rpc),
                                    ",\"code\":", Quote(line.code), absl::StrFormat(",\"ms\":%.3f", line.ms));
  if (!line.message.empty()) absl::StrAppend(&fields, ",\"message\":", Quote(line.message));
  if (!line.peer.empty()) absl::StrAppend(&fields, ",\"peer\":", Quote(line.peer));
  if (!line.traceparent.empty()) absl::StrAppend(&fields, ",\"traceparent\":", Quote(line.traceparent));
  return fields;
}

std::string ToText(const CallLine& line) {
  std::string text = absl::StrFormat("%s %s %s %.0f ms", line.request_id, line.rpc, line.code, line.ms);
  if (!line.traceparent.empty()) absl::StrAppend(&text, " ", line.traceparent);
  if (!line.message.empty()) absl::StrAppend(&text, ": ", line.message);
  return text;
}

}  // namespace halfshade
