#include "server/scene_service.h"

#include <spdlog/spdlog.h>

#include "renderer/status.h"
#include "server/digest.h"
#include "server/request_id.h"
#include "server/scene_name.h"
#include "server/status.h"

namespace halfshade {
namespace {

constexpr int kMaxDigests = 4096;
constexpr int kDefaultPage = 100;
constexpr int kMaxPage = 1000;
constexpr size_t kMaxChunkBytes = 4 << 20;

absl::Status CheckDigest(const std::string& field, const std::string& digest) {
  if (IsSha256Hex(digest)) return absl::OkStatus();
  return absl::InvalidArgumentError(field + ": \"" + digest.substr(0, 80) + "\"; must be 64 lower-case hex digits");
}

grpc::Status Finished(const char* rpc, const absl::Status& status) {
  const std::string id = NextRequestId();
  if (!status.ok()) spdlog::info("{} {} {}", id, rpc, status.ToString());
  return ToGrpcStatus(status, id);
}

// Runs `work` on the pool and finishes the call with what it returns.
template <typename Work>
grpc::ServerUnaryReactor* OnPool(const char* rpc, CpuPool* pool, grpc::CallbackServerContext* context, Work work) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  pool->Run([rpc, reactor, work] { reactor->Finish(Finished(rpc, work())); });
  return reactor;
}

// One upload: chunks go to a temporary file as they come, the commit (digest, fsync, rename) to the pool.
class Upload final : public grpc::ServerReadReactor<v1::UploadBlobRequest> {
 public:
  Upload(Store* store, CpuPool* pool, const Limits& limits, v1::UploadBlobResponse* response)
      : store_(store), pool_(pool), limits_(limits), response_(response) {
    StartRead(&chunk_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) {
      pool_->Run([this] { Finish(Finished("UploadBlob", Commit())); });
      return;
    }
    if (const absl::Status status = Take(); !status.ok()) {
      Finish(Finished("UploadBlob", status));
      return;
    }
    StartRead(&chunk_);
  }

  void OnDone() override { delete this; }

 private:
  absl::Status Take() {
    if (digest_.empty()) {
      RETURN_IF_ERROR(CheckDigest("digest", chunk_.digest()));
      digest_ = chunk_.digest();
      size_bytes_ = chunk_.size_bytes();
      if (size_bytes_ > limits_.scene_bytes) {
        return absl::InvalidArgumentError("size_bytes: " + std::to_string(size_bytes_) +
                                          "; this server takes at most " + std::to_string(limits_.scene_bytes));
      }
      is_here_ = store_->Has(StoreKind::kBlob, digest_);
      if (!is_here_) {
        ASSIGN_OR_RETURN(writer_, store_->Write(StoreKind::kBlob, digest_, size_bytes_));
      }
    }
    if (!chunk_.digest().empty() && chunk_.digest() != digest_) {
      return absl::InvalidArgumentError("digest: changed within one upload");
    }
    if (chunk_.size_bytes() != 0 && chunk_.size_bytes() != size_bytes_) {
      return absl::InvalidArgumentError("size_bytes: " + std::to_string(chunk_.size_bytes()) + " after " +
                                        std::to_string(size_bytes_));
    }
    if (chunk_.offset_bytes() != taken_bytes_) {
      return absl::InvalidArgumentError("offset_bytes: " + std::to_string(chunk_.offset_bytes()) +
                                        "; the next byte is " + std::to_string(taken_bytes_));
    }
    if (chunk_.data().size() > kMaxChunkBytes) {
      return absl::InvalidArgumentError("data: " + std::to_string(chunk_.data().size()) + " bytes; at most " +
                                        std::to_string(kMaxChunkBytes));
    }
    taken_bytes_ += chunk_.data().size();
    if (taken_bytes_ > size_bytes_) {
      return absl::InvalidArgumentError("data: " + std::to_string(taken_bytes_) + " bytes; size_bytes says " +
                                        std::to_string(size_bytes_));
    }
    return is_here_ ? absl::OkStatus() : writer_->Append(chunk_.data());
  }

  absl::Status Commit() {
    if (digest_.empty()) return absl::InvalidArgumentError("digest: missing; the upload has no chunk");
    if (taken_bytes_ != size_bytes_) {
      return absl::InvalidArgumentError("size_bytes: " + std::to_string(size_bytes_) + "; " +
                                        std::to_string(taken_bytes_) + " bytes came");
    }
    if (!is_here_) RETURN_IF_ERROR(writer_->Commit());
    response_->set_committed_bytes(size_bytes_);
    return absl::OkStatus();
  }

  Store* store_;
  CpuPool* pool_;
  const Limits limits_;
  v1::UploadBlobResponse* response_;
  v1::UploadBlobRequest chunk_;
  std::string digest_;
  uint64_t size_bytes_ = 0;
  uint64_t taken_bytes_ = 0;
  bool is_here_ = false;
  std::unique_ptr<Store::Writer> writer_;
};

}  // namespace

grpc::ServerUnaryReactor* SceneServiceImpl::FindMissingBlobs(grpc::CallbackServerContext* context,
                                                             const v1::FindMissingBlobsRequest* request,
                                                             v1::FindMissingBlobsResponse* response) {
  const auto find = [&]() -> absl::Status {
    if (request->digests_size() > kMaxDigests) {
      return absl::InvalidArgumentError("digests: " + std::to_string(request->digests_size()) + "; at most " +
                                        std::to_string(kMaxDigests));
    }
    for (int i = 0; i < request->digests_size(); ++i) {
      RETURN_IF_ERROR(CheckDigest("digests[" + std::to_string(i) + "]", request->digests(i)));
      if (!store_->Has(StoreKind::kBlob, request->digests(i))) response->add_missing_digests(request->digests(i));
    }
    return absl::OkStatus();
  };
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(Finished("FindMissingBlobs", find()));
  return reactor;
}

grpc::ServerReadReactor<v1::UploadBlobRequest>* SceneServiceImpl::UploadBlob(grpc::CallbackServerContext*,
                                                                             v1::UploadBlobResponse* response) {
  return new Upload(store_, pool_, limits_, response);
}

grpc::ServerUnaryReactor* SceneServiceImpl::QueryUpload(grpc::CallbackServerContext* context,
                                                        const v1::QueryUploadRequest* request,
                                                        v1::QueryUploadResponse*) {
  const absl::Status status = CheckDigest("digest", request->digest());
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(Finished("QueryUpload",
                           status.ok() ? absl::UnimplementedError("SceneService.QueryUpload: resuming an upload is not "
                                                                  "available in this version; send the blob again")
                                       : status));
  return reactor;
}

grpc::ServerUnaryReactor* SceneServiceImpl::CreateScene(grpc::CallbackServerContext* context,
                                                        const v1::CreateSceneRequest* request,
                                                        v1::CreateSceneResponse* response) {
  return OnPool("CreateScene", pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(SceneCatalog::Created created, catalog_->Create(*request));
    *response->mutable_scene() = std::move(created.scene);
    response->set_existed(created.existed);
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* SceneServiceImpl::GetScene(grpc::CallbackServerContext* context,
                                                     const v1::GetSceneRequest* request,
                                                     v1::GetSceneResponse* response) {
  return OnPool("GetScene", pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(*response->mutable_scene(), catalog_->Describe(request->name()));
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* SceneServiceImpl::ListScenes(grpc::CallbackServerContext* context,
                                                       const v1::ListScenesRequest* request,
                                                       v1::ListScenesResponse* response) {
  return OnPool("ListScenes", pool_, context, [this, request, response]() -> absl::Status {
    if (request->page_size() < 0 || request->page_size() > kMaxPage) {
      return absl::InvalidArgumentError("page_size: " + std::to_string(request->page_size()) + "; must be 0 to " +
                                        std::to_string(kMaxPage));
    }
    if (!request->page_token().empty() && !IsSceneName(request->page_token())) {
      return absl::InvalidArgumentError("page_token: not one of ListScenes");
    }
    const size_t count = size_t(request->page_size() == 0 ? kDefaultPage : request->page_size());
    const std::vector<std::string> names = catalog_->List(request->page_token(), count + 1);
    for (size_t i = 0; i < std::min(count, names.size()); ++i) {
      absl::StatusOr<v1::Scene> scene = catalog_->Describe(names[i]);
      // Deleted meanwhile, or damaged: not in the list.
      if (scene.ok()) *response->add_scenes() = *std::move(scene);
    }
    if (names.size() > count) response->set_next_page_token(names[count - 1]);
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* SceneServiceImpl::DeleteScene(grpc::CallbackServerContext* context,
                                                        const v1::DeleteSceneRequest* request,
                                                        v1::DeleteSceneResponse*) {
  return OnPool("DeleteScene", pool_, context, [this, request] { return catalog_->Delete(request->name()); });
}

}  // namespace halfshade
