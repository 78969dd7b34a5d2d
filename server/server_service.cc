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
  std::vector<CacheReport> caches = workers_->Caches();
  const ResultCache::Counters results = plant_->results->counters();
  caches.insert(caches.begin(), {"result", results.hits, results.misses, results.bytes});
  caches.insert(caches.begin(), {"scene", counters.hits, counters.misses, counters.bytes});
  for (const CacheReport& cache : caches) {
    v1::Cache* out = response->add_caches();
    out->set_name(cache.name);
    out->set_hits(cache.hits);
    out->set_misses(cache.misses);
    out->set_bytes(cache.bytes);
  }
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

}  // namespace halfshade
