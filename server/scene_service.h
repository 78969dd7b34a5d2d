// SceneService over the catalog. Handlers hand their work to a pool and return.
#pragma once

#include "halfshade/v1/scene.grpc.pb.h"
#include "server/call_log.h"
#include "server/cpu_pool.h"
#include "server/limits.h"
#include "server/scene_catalog.h"
#include "server/store.h"

namespace halfshade {

class SceneServiceImpl final : public v1::SceneService::CallbackService {
 public:
  // All outlive the service. Loading a scene takes seconds and writing a chunk milliseconds: `scene_pool` does what may
  // load, `disk_pool` the rest.
  SceneServiceImpl(Store* store, SceneCatalog* catalog, CpuPool* scene_pool, CpuPool* disk_pool, CallLog* log,
                   const Limits& limits)
      : store_(store), catalog_(catalog), scene_pool_(scene_pool), disk_pool_(disk_pool), log_(log), limits_(limits) {}

  grpc::ServerUnaryReactor* FindMissingBlobs(grpc::CallbackServerContext* context,
                                             const v1::FindMissingBlobsRequest* request,
                                             v1::FindMissingBlobsResponse* response) override;
  grpc::ServerReadReactor<v1::UploadBlobRequest>* UploadBlob(grpc::CallbackServerContext* context,
                                                             v1::UploadBlobResponse* response) override;
  grpc::ServerUnaryReactor* QueryUpload(grpc::CallbackServerContext* context, const v1::QueryUploadRequest* request,
                                        v1::QueryUploadResponse* response) override;
  grpc::ServerUnaryReactor* CreateScene(grpc::CallbackServerContext* context, const v1::CreateSceneRequest* request,
                                        v1::CreateSceneResponse* response) override;
  grpc::ServerUnaryReactor* GetScene(grpc::CallbackServerContext* context, const v1::GetSceneRequest* request,
                                     v1::GetSceneResponse* response) override;
  grpc::ServerUnaryReactor* ListScenes(grpc::CallbackServerContext* context, const v1::ListScenesRequest* request,
                                       v1::ListScenesResponse* response) override;
  grpc::ServerUnaryReactor* DeleteScene(grpc::CallbackServerContext* context, const v1::DeleteSceneRequest* request,
                                        v1::DeleteSceneResponse* response) override;

 private:
  Store* store_;
  SceneCatalog* catalog_;
  CpuPool* scene_pool_;
  CpuPool* disk_pool_;
  CallLog* log_;
  const Limits limits_;
};

}  // namespace halfshade
