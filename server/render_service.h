// RenderService: a call goes from its handler to the CPU pool (scene, validation), to the render queue, to a GL thread,
// back to the CPU pool (encoding) and out. It is finished exactly once, by whichever comes first: its result, its
// deadline (an alarm, not the next dequeue), or its cancellation.
#pragma once

#include <atomic>
#include <cstdint>

#include "halfshade/v1/render.grpc.pb.h"
#include "server/admission.h"
#include "server/cpu_pool.h"
#include "server/limits.h"
#include "server/scene_catalog.h"

namespace halfshade {

// What the handlers share; all outlives the service.
struct RenderPlant {
  SceneCatalog* catalog = nullptr;
  CpuPool* pool = nullptr;
  RenderQueue* queue = nullptr;
  Limits limits;
  std::atomic<bool> is_stopping{false};  // renders under way give up
  std::atomic<uint64_t> renders_ok{0};
  std::atomic<uint64_t> renders_failed{0};
};

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
