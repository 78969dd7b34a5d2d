#include "server/call_log.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <string_view>

#include "server/log.h"
#include "server/request_id.h"
#include "server/status.h"

namespace halfshade {
namespace {

spdlog::level::level_enum LevelOf(const absl::Status& status) {
  if (status.ok()) return spdlog::level::debug;
  return absl::IsInternal(status) ? spdlog::level::err : spdlog::level::info;
}

bool IsLowerHex(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool IsZero(std::string_view text) { return text.find_first_not_of('0') == std::string_view::npos; }

}  // namespace

bool IsTraceparent(const std::string& text) {
  if (text.size() != 55 || text[2] != '-' || text[35] != '-' || text[52] != '-') return false;
  const std::string_view all = text, trace = all.substr(3, 32), parent = all.substr(36, 16);
  return all.substr(0, 2) == "00" && IsLowerHex(trace) && IsLowerHex(parent) && IsLowerHex(all.substr(53)) &&
         !IsZero(trace) && !IsZero(parent);
}

CallLog::CallLog(Metrics* metrics) : metrics_(metrics), logger_(CallLogger()) {}

CallLog::Call CallLog::Begin(const char* rpc, const grpc::CallbackServerContext& context) {
  Call call{rpc, NextRequestId(), context.peer(), "", std::chrono::steady_clock::now()};
  const auto& metadata = context.client_metadata();
  if (const auto found = metadata.find("traceparent"); found != metadata.end()) {
    std::string text(found->second.data(), found->second.size());
    if (IsTraceparent(text)) call.traceparent = std::move(text);
  }
  return call;
}

grpc::Status CallLog::End(const Call& call, const absl::Status& status, grpc::CallbackServerContext* context) {
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - call.begin).count();
  metrics_->CountCall(call.rpc, status.code(), seconds);
  if (const auto level = LevelOf(status); logger_->should_log(level)) {
    LogCall(*logger_, level,
            {.request_id = call.id,
             .rpc = call.rpc,
             .peer = call.peer,
             .traceparent = call.traceparent,
             .code = absl::StatusCodeToString(status.code()),
             .message = std::string(status.message()),
             .ms = seconds * 1e3});
  }
  context->AddTrailingMetadata(kRequestIdKey, call.id);
  return EndOfCall(status, call.id, context);
}

}  // namespace halfshade
