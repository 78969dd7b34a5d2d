#include "server/server_service.h"

namespace halfshade {

grpc::ServerUnaryReactor* ServerServiceImpl::GetServerInfo(grpc::CallbackServerContext* context,
                                                           const v1::GetServerInfoRequest*,
                                                           v1::GetServerInfoResponse* response) {
  *response = info_;
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

grpc::ServerUnaryReactor* ServerServiceImpl::GetStatistics(grpc::CallbackServerContext* context,
                                                           const v1::GetStatisticsRequest*,
                                                           v1::GetStatisticsResponse* response) {
  response->set_renders_ok(plant_->renders_ok);
  response->set_renders_failed(plant_->renders_failed);
  response->set_queued(uint32_t(plant_->queue->waiting()));
  response->set_scenes(uint32_t(store_->List(StoreKind::kScene).size()));
  response->set_blob_bytes(store_->size_bytes());
  const SceneCache::Counters counters = cache_->counters();
  v1::Cache* cache = response->add_caches();
  cache->set_name("scene");
  cache->set_hits(counters.hits);
  cache->set_misses(counters.misses);
  cache->set_bytes(counters.bytes);
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

}  // namespace halfshade
