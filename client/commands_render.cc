// halfshade render
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "client/exit_code.h"
#include "client/input_file.h"
#include "client/output_file.h"
#include "client/session.h"
#include "renderer/status.h"
#include "server/scene_name.h"

namespace halfshade {
namespace {

absl::Status WriteImages(const v1::RenderResponse& response, const std::vector<std::string>& paths) {
  if (response.images_size() != static_cast<int>(paths.size())) {
    return absl::InternalError(absl::StrCat("the server sent ", response.images_size(), " images, not ", paths.size()));
  }
  std::vector<OutputFile> files;
  for (size_t i = 0; i < paths.size(); ++i) {
    if (!paths[i].empty()) files.push_back({paths[i], response.images(static_cast<int>(i)).data()});
  }
  return WriteOutputFiles(files);
}

// "out.png: 1280 x 720, multi_map, 812 ms on llvmpipe (...)", and what --certify measured: ", error 0.0042 +- 0.0007"
std::string Summary(const std::string& path, const v1::RenderResponse& response, int index) {
  const v1::RenderReport& report = response.report();
  const v1::OutputImage& image = response.images(index);
  std::string error;
  if (report.error().has_measured()) {
    error = absl::StrFormat(", error %.4f +- %.4f", report.error().measured(), report.error().ci95());
  }
  return absl::StrFormat("%s: %d x %d, %s, %.0f ms on %s%s", path, image.width(), image.height(), report.method(),
                         report.timing().total_ms(), report.gl_renderer(), error);
}

}  // namespace

absl::Status RunRender(const GlobalFlags& global, const RenderCommand& command) {
  ASSIGN_OR_RETURN(PreparedRender job, PrepareRender(command.flags));
  if (command.prints_request) {
    if (!IsSceneName(job.request.scene())) RETURN_IF_ERROR(CheckInputFile(job.request.scene()));
    return Print(ToJson(job.request, /*with_defaults=*/false));
  }
  if (job.files.empty() && !global.wants_json) {
    return UsageError("render: nothing to do without -o FILE, --json or --print-request");
  }
  for (const std::string& path : job.files) {
    if (!path.empty()) RETURN_IF_ERROR(CheckCanWrite(path));
  }
  ASSIGN_OR_RETURN(const std::unique_ptr<SceneFiles> files, TakeSceneFiles(&job.request));
  ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(global));
  ASSIGN_OR_RETURN(const v1::RenderResponse response, session->client().Render(job.request, files.get()));
  if (!job.files.empty()) RETURN_IF_ERROR(WriteImages(response, job.files));
  for (size_t i = 0; i < job.files.size(); ++i) {
    if (job.files[i].empty()) continue;
    session->progress().Say(Summary(job.files[i], response, static_cast<int>(i)));
  }
  return global.wants_json ? Print(ToJson(response.report(), /*with_defaults=*/true)) : absl::OkStatus();
}

}  // namespace halfshade
