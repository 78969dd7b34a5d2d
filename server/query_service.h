// QueryVisibility: from its handler to the CPU pool (scene, validation), the render queue, a GL thread, and out. It is
// finished exactly once: by its result, its deadline (an alarm) or its cancellation.
#pragma once

#include "server/render_service.h"

namespace halfshade {

// Starts a call; the reactor owns itself. `plant` outlives it.
grpc::ServerUnaryReactor* StartQuery(RenderPlant* plant, grpc::CallbackServerContext* context,
                                     const v1::QueryVisibilityRequest& query, v1::QueryVisibilityResponse* response);

}  // namespace halfshade
