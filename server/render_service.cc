#include "server/render_service.h"

#include <memory>
#include <string>

#include "server/plan_service.h"
#include "server/query_service.h"
#include "server/render_stream.h"

namespace halfshade {
namespace {

class UnaryRenderCall final : public grpc::ServerUnaryReactor, public RenderCall {
 public:
  UnaryRenderCall(RenderPlant* plant, grpc::CallbackServerContext* context, const v1::RenderRequest& request,
                  v1::RenderResponse* response)
      : RenderCall(plant, context, request, "Render", plant->limits), response_(response) {}

  void OnCancel() override { GiveUp(absl::CancelledError("cancelled by the client")); }
  void OnDone() override { Release(); }

 private:
  void OnQueued(v1::RenderReport) override {}
  void Deliver(v1::RenderResponse response) override {
    if (!ClaimSuccess(response.report())) return;
    response_->Swap(&response);
    Finish(grpc::Status::OK);
  }
  void FinishRpc(const grpc::Status& status) override { Finish(status); }

  v1::RenderResponse* response_;
};

}  // namespace

grpc::ServerUnaryReactor* RenderServiceImpl::Render(grpc::CallbackServerContext* context,
                                                    const v1::RenderRequest* request, v1::RenderResponse* response) {
  const auto call = std::make_shared<UnaryRenderCall>(plant_, context, *request, response);
  call->Start();
  return call.get();
}

grpc::ServerWriteReactor<v1::RenderStreamResponse>* RenderServiceImpl::RenderStream(
    grpc::CallbackServerContext* context, const v1::RenderStreamRequest* request) {
  return StartRenderStream(plant_, context, *request);
}

grpc::ServerUnaryReactor* RenderServiceImpl::PlanRender(grpc::CallbackServerContext* context,
                                                        const v1::PlanRenderRequest* plan,
                                                        v1::PlanRenderResponse* response) {
  return StartPlan(plant_, context, *plan, response);
}

grpc::ServerUnaryReactor* RenderServiceImpl::QueryVisibility(grpc::CallbackServerContext* context,
                                                             const v1::QueryVisibilityRequest* request,
                                                             v1::QueryVisibilityResponse* response) {
  return StartQuery(plant_, context, *request, response);
}

}  // namespace halfshade
