// halfshade plan
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "client/session.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// A line each: the method with its options and the reason, the predicted error, what is left out and why.
std::string ToText(const v1::RenderReport& plan) {
  std::string text = absl::StrCat("method   ", plan.method(), "\n");
  const google::protobuf::Reflection* reflection = plan.options().GetReflection();
  std::vector<const google::protobuf::FieldDescriptor*> set;
  reflection->ListFields(plan.options(), &set);
  for (const auto* method : set) {
    absl::StrAppend(&text, "options  ", reflection->GetMessage(plan.options(), method).ShortDebugString(), "\n");
  }
  if (!plan.reason().empty()) absl::StrAppend(&text, "reason   ", plan.reason(), "\n");
  if (plan.error().has_predicted()) absl::StrAppendFormat(&text, "error    %.4f predicted\n", plan.error().predicted());
  if (plan.timing().cpu_ms() > 0)
    absl::StrAppendFormat(&text, "cost     %.0f CPU-ms predicted\n", plan.timing().cpu_ms());
  for (const v1::Pass& pass : plan.passes()) {
    absl::StrAppend(&text, pass.skipped() ? "skipped  " : "pass     ", pass.name(), pass.reason().empty() ? "" : ": ",
                    pass.reason(), "\n");
  }
  return text;
}

}  // namespace

absl::Status RunPlan(const GlobalFlags& global, const RenderFlags& flags) {
  ASSIGN_OR_RETURN(PreparedRender job, PrepareRender(flags));
  ASSIGN_OR_RETURN(const std::unique_ptr<SceneFiles> files, TakeSceneFiles(&job.request));
  ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(global));
  v1::PlanRenderRequest request;
  *request.mutable_request() = job.request;
  ASSIGN_OR_RETURN(const v1::PlanRenderResponse response, session->client().PlanRender(request, files.get()));
  return Print(global.wants_json ? ToJson(response.plan(), /*with_defaults=*/true) : ToText(response.plan()));
}

}  // namespace halfshade
