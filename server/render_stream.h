// RenderStream: the plan, then a header and chunks per image, then the report; `progressive`: the same for each coarse
// result before, whose images are smaller and whose report tells its error.
#pragma once

#include <memory>

#include "halfshade/v1/render.grpc.pb.h"
#include "server/render_call.h"

namespace halfshade {

// Starts a call that lives until gRPC is done with it. One write is in flight at a time; a chunk is cut from the
// encoded image when the one before it has gone, so that a stream buffers two messages of 256 KiB at most, beside the
// encoded images that RenderPlant::in_flight counts. A reader that takes nothing for RenderPlant::stream_stall is told
// DEADLINE_EXCEEDED and, where it does not take that either for as long again, cut off.
grpc::ServerWriteReactor<v1::RenderStreamResponse>* StartRenderStream(RenderPlant* plant,
                                                                      grpc::CallbackServerContext* context,
                                                                      const v1::RenderStreamRequest& request);

}  // namespace halfshade
