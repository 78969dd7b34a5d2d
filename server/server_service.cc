#include "server/server_service.h"

namespace halfshade {

grpc::ServerUnaryReactor* ServerServiceImpl::GetServerInfo(grpc::CallbackServerContext* context,
                                                           const v1::GetServerInfoRequest*,
                                                           v1::GetServerInfoResponse* response) {
  const CallLog::Call call = CallLog::Begin("GetServerInfo", *context);
  *response = info_;
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(plant_->log->End(call, absl::OkStatus(), context));
  return reactor;
}

grpc::ServerUnaryReactor* ServerServiceImpl::GetStatistics(grpc::CallbackServerContext* context,
                                                           const v1::GetStatisticsRequest*,
                                                           v1::GetStatisticsResponse* response) {
  const CallLog::Call call = CallLog::Begin("GetStatistics", *context);
  response->set_renders_ok(plant_->renders_ok);
  response->set_renders_failed(plant_->renders_failed);
  response->set_queued(uint32_t(plant_->queue->waiting()));
  response->set_scenes(uint32_t(store_->List(StoreKind::kScene).size()));
  response->set_blob_bytes(store_->size_bytes());
  for (const CacheReport& cache : Caches()) {
    v1::Cache* out = response->add_caches();
    out->set_name(cache.name);
    out->set_hits(cache.hits);
    out->set_misses(cache.misses);
    out->set_bytes(cache.bytes);
  }
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(plant_->log->End(call, absl::OkStatus(), context));
  return reactor;
}

std::vector<CacheReport> ServerServiceImpl::Caches() const {
  const SceneCache::Counters scenes = cache_->counters();
  const ResultCache::Counters results = plant_->results->counters();
  std::vector<CacheReport> caches = {{"scene", scenes.hits, scenes.misses, scenes.bytes},
                                     {"result", results.hits, results.misses, results.bytes}};
  const std::vector<CacheReport> on_contexts = workers_->Caches();
  caches.insert(caches.end(), on_contexts.begin(), on_contexts.end());
  return caches;
}

std::vector<Metrics::Sample> ServerServiceImpl::Samples() const {
  std::vector<Metrics::Sample> samples = {
      {"halfshade_build_info", "1, with the version.", false, "version", info_.version(), 1},
      {"halfshade_queue_waiting", "Renders and queries that wait for a context.", false, "", "",
       double(plant_->queue->waiting())},
      {"halfshade_queue_capacity", "How many may wait.", false, "", "", double(plant_->limits.queue)},
      {"halfshade_in_flight_bytes", "Images drawn, encoded or sent, before compression.", false, "", "",
       double(plant_->in_flight->used())},
      {"halfshade_contexts", "GL contexts.", false, "", "", double(workers_->workers().size())},
      {"halfshade_contexts_lost", "GL contexts that do not draw now.", false, "", "", double(workers_->lost())},
      {"halfshade_context_losses_total", "GL contexts that were lost.", true, "", "", double(workers_->losses())},
      {"halfshade_store_bytes", "Bytes that the scene store holds.", false, "", "", double(store_->size_bytes())}};
  const std::vector<CacheReport> caches = Caches();
  for (const CacheReport& cache : caches) {
    samples.push_back(
        {"halfshade_cache_hits_total", "Found in the cache.", true, "cache", cache.name, double(cache.hits)});
  }
  for (const CacheReport& cache : caches) {
    samples.push_back(
        {"halfshade_cache_misses_total", "Not found in the cache.", true, "cache", cache.name, double(cache.misses)});
  }
  for (const CacheReport& cache : caches) {
    samples.push_back({"halfshade_cache_bytes", "What the cache holds; GL memory for what is on contexts.", false,
                       "cache", cache.name, double(cache.bytes)});
  }
  return samples;
}

}  // namespace halfshade
