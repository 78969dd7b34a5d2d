// RenderService: one call object per rpc (server/render_call.h tells their story).
#pragma once

#include "halfshade/v1/render.grpc.pb.h"
#include "server/render_call.h"

namespace halfshade {

class RenderServiceImpl final : public v1::RenderService::CallbackService {
 public:
  explicit RenderServiceImpl(RenderPlant* plant) : plant_(plant) {}

  grpc::ServerUnaryReactor* Render(grpc::CallbackServerContext* context, const v1::RenderRequest* request,
                                   v1::RenderResponse* response) override;
  grpc::ServerWriteReactor<v1::RenderStreamResponse>* RenderStream(grpc::CallbackServerContext* context,
                                                                   const v1::RenderStreamRequest* request) override;
  grpc::ServerUnaryReactor* PlanRender(grpc::CallbackServerContext* context, const v1::PlanRenderRequest* request,
                                       v1::PlanRenderResponse* response) override;
  grpc::ServerUnaryReactor* QueryVisibility(grpc::CallbackServerContext* context,
                                            const v1::QueryVisibilityRequest* request,
                                            v1::QueryVisibilityResponse* response) override;

 private:
  RenderPlant* plant_;
};

}  // namespace halfshade
