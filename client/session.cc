#include "client/session.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <google/protobuf/util/json_util.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "client/exit_code.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

absl::StatusOr<std::vector<std::string>> ReadServers(const std::string& text) {
  std::vector<std::string> servers;
  for (const auto& part : absl::StrSplit(text, ',', absl::SkipWhitespace())) {
    const std::string server(absl::StripAsciiWhitespace(part));
    const size_t colon = server.rfind(':');
    if (colon == std::string::npos || colon == 0 || colon + 1 == server.size()) {
      return UsageError(absl::StrCat("--server: '", server, "' is not HOST:PORT or unix:PATH"));
    }
    servers.push_back(server);
  }
  return servers;
}

gl::Backend BackendOf(const std::string& name) {
  if (name == "egl") return gl::Backend::kEgl;
  return name == "osmesa" ? gl::Backend::kOsmesa : gl::Backend::kAuto;
}

}  // namespace

absl::Status Session::PrepareInProcess(const GlobalFlags& global, ServerOptions* options) {
  gl::LimitDriverThreads(global.contexts);
  // stdout is for data; what the service notes beside its errors is in their messages too.
  spdlog::set_default_logger(spdlog::stderr_logger_mt("halfshade"));
  spdlog::set_level(spdlog::level::err);
  ASSIGN_OR_RETURN(PrivateFolder store, PrivateFolder::Create());
  options->scene_store_dir = store.path();
  options->keeps_store = false;
  options->gl.backend = BackendOf(global.gl);
  options->gl.egl_device = global.egl_device;
  options->contexts = global.contexts;
  store_.emplace(std::move(store));
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<Session>> Session::Open(const GlobalFlags& global) { return Open(global, false); }

absl::StatusOr<std::unique_ptr<Session>> Session::OpenForMany(const GlobalFlags& global) { return Open(global, true); }

absl::StatusOr<std::unique_ptr<Session>> Session::Open(const GlobalFlags& global, bool is_for_many) {
  std::unique_ptr<Session> session(new Session);
  ClientOptions options;
  ASSIGN_OR_RETURN(options.servers, ReadServers(global.servers));
  if (options.servers.empty()) RETURN_IF_ERROR(session->PrepareInProcess(global, &options.in_process));
  options.timeout = std::chrono::duration<double>(global.timeout_s);
  options.is_timeout_per_call = is_for_many;
  if (!is_for_many) {
    options.progress = [&progress = session->progress_](const char* what, double done) { progress.Show(what, done); };
  }
  options.notice = [&progress = session->progress_](const std::string& sentence) { progress.Say(sentence); };
  ASSIGN_OR_RETURN(session->client_, Client::Connect(std::move(options)));
  return session;
}

std::string ToJson(const google::protobuf::Message& message, bool with_defaults) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.always_print_primitive_fields = with_defaults;
  std::string text;
  // Fails only for an Any of an unknown type, which no message of ours has.
  (void)google::protobuf::util::MessageToJsonString(message, &text, options);
  return text;
}

absl::Status Print(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) {
    return absl::OkStatus();
  }
  return CannotWriteError(absl::StrCat("stdout: ", std::strerror(errno)));
}

}  // namespace halfshade
