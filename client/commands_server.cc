// halfshade info, health, doctor
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "client/session.h"
#include "renderer/gl/context.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

std::string ToText(const std::string& server, const v1::GetServerInfoResponse& info) {
  std::string text =
      absl::StrCat("server      ", server.empty() ? "in this process" : server, "\nversion     ", info.version(), "\n");
  for (const v1::ContextInfo& context : info.contexts()) {
    absl::StrAppend(&text, "context     ", context.description(), ": ", context.gl_renderer(), ", OpenGL ",
                    context.gl_version(), "\n");
  }
  const v1::Limits& limits = info.limits();
  return absl::StrCat(text, "methods     ", absl::StrJoin(info.methods(), ", "), "\nfeatures    ",
                      absl::StrJoin(info.features(), ", "), "\nimage       at most ", limits.image_width(), " x ",
                      limits.image_height(), " pixels, ", limits.render_reply_bytes(),
                      " bytes in one reply\nscene       at most ", limits.scene_bytes(), " bytes, ",
                      limits.scene_triangles(), " triangles\n");
}

}  // namespace

absl::Status RunInfo(const GlobalFlags& global) {
  ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(global));
  for (const std::string& server : session->client().servers()) {
    ASSIGN_OR_RETURN(const v1::GetServerInfoResponse info, session->client().GetServerInfo(server));
    RETURN_IF_ERROR(Print(global.wants_json ? ToJson(info, /*with_defaults=*/true) : ToText(server, info)));
  }
  return absl::OkStatus();
}

absl::Status RunHealth(const GlobalFlags& global) {
  ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(global));
  absl::Status worst;
  for (const std::string& server : session->client().servers()) {
    ASSIGN_OR_RETURN(const std::string health, session->client().CheckHealth(server));
    const std::string prefix = session->client().servers().size() > 1 ? server + " " : "";
    RETURN_IF_ERROR(Print(global.wants_json ? nlohmann::json{{"server", server}, {"status", health}}.dump() + "\n"
                                            : prefix + health + "\n"));
    if (health != "SERVING") worst = absl::UnavailableError(absl::StrCat(prefix, "not serving"));
  }
  return worst;
}

absl::Status RunDoctor(const GlobalFlags& global) {
  const std::vector<gl::DoctorLine> lines = gl::Diagnose();
  nlohmann::json json = nlohmann::json::array();
  std::string text;
  for (const gl::DoctorLine& line : lines) {
    json.push_back({{"what", line.what}, {"ok", line.is_ok}, {"detail", line.detail}});
    absl::StrAppend(&text, line.is_ok ? "ok      " : "failed  ", line.what, ": ", line.detail, "\n");
  }
  RETURN_IF_ERROR(Print(global.wants_json ? json.dump(1) + "\n" : text));
  const bool is_any_ok = std::any_of(lines.begin(), lines.end(), [](const gl::DoctorLine& line) { return line.is_ok; });
  return is_any_ok ? absl::OkStatus() : absl::UnavailableError("no way to an OpenGL 4.5 context works here");
}

}  // namespace halfshade
