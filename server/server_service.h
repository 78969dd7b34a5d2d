// ServerService: what the server is. The answer is made once, at the start.
#pragma once

#include "halfshade/v1/server.grpc.pb.h"
#include "server/gl_worker_pool.h"
#include "server/render_service.h"
#include "server/scene_cache.h"
#include "server/store.h"

namespace halfshade {

class ServerServiceImpl final : public v1::ServerService::CallbackService {
 public:
  // The pointers outlive the service.
  ServerServiceImpl(v1::GetServerInfoResponse info, const RenderPlant* plant, const Store* store,
                    const SceneCache* cache, const GlWorkerPool* workers)
      : info_(std::move(info)), plant_(plant), store_(store), cache_(cache), workers_(workers) {}

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context, const v1::GetServerInfoRequest* request,
                                          v1::GetServerInfoResponse* response) override;
  grpc::ServerUnaryReactor* GetStatistics(grpc::CallbackServerContext* context, const v1::GetStatisticsRequest* request,
                                          v1::GetStatisticsResponse* response) override;

  // What /metrics has beside counts of calls: sizes and caches as they are now.
  std::vector<Metrics::Sample> Samples() const;

 private:
  std::vector<CacheReport> Caches() const;

  const v1::GetServerInfoResponse info_;
  const RenderPlant* plant_;
  const Store* store_;
  const SceneCache* cache_;
  const GlWorkerPool* workers_;
};

}  // namespace halfshade
