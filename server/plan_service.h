// PlanRender: what a render would do, without drawing. On the CPU pool; no queue, no GL.
#pragma once

#include <grpcpp/server_context.h>

#include "server/render_call.h"

namespace halfshade {

grpc::ServerUnaryReactor* StartPlan(RenderPlant* plant, grpc::CallbackServerContext* context,
                                    const v1::PlanRenderRequest& plan, v1::PlanRenderResponse* response);

}  // namespace halfshade
