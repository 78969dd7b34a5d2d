#include "client/command_support.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <google/protobuf/util/json_util.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "client/exit_code.h"

namespace halfshade {

absl::StatusOr<std::unique_ptr<Client>> ConnectClient(const GlobalFlags& global, Progress* progress) {
  ClientOptions options;
  for (const auto& part : absl::StrSplit(global.servers, ',', absl::SkipWhitespace())) {
    const std::string server(absl::StripAsciiWhitespace(part));
    const size_t colon = server.rfind(':');
    if (colon == std::string::npos || colon == 0 || colon + 1 == server.size()) {
      return UsageError(absl::StrCat("--server: '", server, "' is not HOST:PORT or unix:PATH"));
    }
    options.servers.push_back(server);
  }
  options.in_process.gl.backend = global.gl == "egl"      ? gl::Backend::kEgl
                                  : global.gl == "osmesa" ? gl::Backend::kOsmesa
                                                          : gl::Backend::kAuto;
  options.in_process.gl.egl_device = global.egl_device;
  options.in_process.contexts = global.contexts;
  options.timeout = std::chrono::duration<double>(global.timeout_s);
  options.progress = [progress](const char* what, double done) { progress->Show(what, done); };
  options.notice = [progress](const std::string& sentence) { progress->Say(sentence); };
  return Client::Connect(std::move(options));
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
