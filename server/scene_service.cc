#include "server/scene_service.h"

#include "renderer/status.h"
#include "server/digest.h"
#include "server/scene_name.h"

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

// Runs `work` on the pool and finishes the call with what it returns.
template <typename Work>
grpc::ServerUnaryReactor* OnPool(CallLog* log, const char* rpc, CpuPool* pool, grpc::CallbackServerContext* context,
                                 Work work) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  pool->Run([log, call = CallLog::Begin(rpc, *context), reactor, context, work] {
    reactor->Finish(log->End(call, work(), context));
  });
  return reactor;
}

// One upload: each chunk goes to the store on the pool, and the next is read when it is there. Whatever ends the call
// before the commit leaves what came so far, to go on from.
class Upload final : public grpc::ServerReadReactor<v1::UploadBlobRequest> {
 public:
  Upload(Store* store, CpuPool* pool, CallLog* log, const Limits& limits, grpc::CallbackServerContext* context,
         v1::UploadBlobResponse* response)
      : store_(store),
        pool_(pool),
        log_(log),
        call_(CallLog::Begin("UploadBlob", *context)),
        limits_(limits),
        context_(context),
        response_(response) {
    StartRead(&chunk_);
  }

  void OnReadDone(bool ok) override {
    pool_->Run([this, ok] {
      absl::Status status = ok ? Take() : Commit();
      // Here already: the rest need not be sent.
      const bool is_here = absl::IsAlreadyExists(status);
      if (is_here) status = AnswerFromStore();
      if (ok && status.ok() && !is_here) {
        StartRead(&chunk_);
        return;
      }
      writer_.reset();  // on the pool: it may wait for the disk
      Finish(log_->End(call_, status, context_));
    });
  }

  void OnDone() override { delete this; }

 private:
  absl::Status Take() {
    if (writer_ == nullptr) {
      RETURN_IF_ERROR(Begin());
    } else {
      RETURN_IF_ERROR(CheckNext());
    }
    if (chunk_.data().size() > kMaxChunkBytes) {
      return absl::InvalidArgumentError("data: " + std::to_string(chunk_.data().size()) + " bytes; at most " +
                                        std::to_string(kMaxChunkBytes));
    }
    if (chunk_.data().size() > size_bytes_ - taken_bytes_) {
      return absl::InvalidArgumentError("data: " + std::to_string(taken_bytes_ + chunk_.data().size()) +
                                        " bytes; size_bytes says " + std::to_string(size_bytes_));
    }
    RETURN_IF_ERROR(writer_->Append(chunk_.data()));
    taken_bytes_ += chunk_.data().size();
    return absl::OkStatus();
  }

  absl::Status Begin() {
    RETURN_IF_ERROR(CheckDigest("digest", chunk_.digest()));
    if (chunk_.size_bytes() > limits_.scene_bytes) {
      return absl::InvalidArgumentError("size_bytes: " + std::to_string(chunk_.size_bytes()) +
                                        "; this server takes at most " + std::to_string(limits_.scene_bytes));
    }
    if (chunk_.offset_bytes() > chunk_.size_bytes()) {
      return absl::InvalidArgumentError("offset_bytes: " + std::to_string(chunk_.offset_bytes()) +
                                        "; size_bytes says " + std::to_string(chunk_.size_bytes()));
    }
    digest_ = chunk_.digest();
    size_bytes_ = chunk_.size_bytes();
    taken_bytes_ = chunk_.offset_bytes();
    ASSIGN_OR_RETURN(writer_, store_->Write(StoreKind::kBlob, digest_, size_bytes_, taken_bytes_));
    return absl::OkStatus();
  }

  absl::Status CheckNext() const {
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
    return absl::OkStatus();
  }

  absl::Status Commit() {
    if (writer_ == nullptr) return absl::InvalidArgumentError("digest: missing; the upload has no chunk");
    if (taken_bytes_ != size_bytes_) {
      return absl::InvalidArgumentError("size_bytes: " + std::to_string(size_bytes_) + "; " +
                                        std::to_string(taken_bytes_) + " bytes came");
    }
    RETURN_IF_ERROR(writer_->Commit());
    response_->set_committed_bytes(size_bytes_);
    return absl::OkStatus();
  }

  absl::Status AnswerFromStore() {
    const uint64_t held = store_->SizeOf(StoreKind::kBlob, digest_);
    if (size_bytes_ != held) {
      return absl::InvalidArgumentError("size_bytes: " + std::to_string(size_bytes_) + "; the blob is here and has " +
                                        std::to_string(held));
    }
    response_->set_committed_bytes(held);
    return absl::OkStatus();
  }

  Store* store_;
  CpuPool* pool_;
  CallLog* log_;
  const CallLog::Call call_;
  const Limits limits_;
  grpc::CallbackServerContext* context_;
  v1::UploadBlobResponse* response_;
  v1::UploadBlobRequest chunk_;
  std::string digest_;
  uint64_t size_bytes_ = 0;
  uint64_t taken_bytes_ = 0;
  std::unique_ptr<Store::Writer> writer_;
};

}  // namespace

grpc::ServerUnaryReactor* SceneServiceImpl::FindMissingBlobs(grpc::CallbackServerContext* context,
                                                             const v1::FindMissingBlobsRequest* request,
                                                             v1::FindMissingBlobsResponse* response) {
  const CallLog::Call call = CallLog::Begin("FindMissingBlobs", *context);
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
  reactor->Finish(log_->End(call, find(), context));
  return reactor;
}

grpc::ServerReadReactor<v1::UploadBlobRequest>* SceneServiceImpl::UploadBlob(grpc::CallbackServerContext* context,
                                                                             v1::UploadBlobResponse* response) {
  return new Upload(store_, disk_pool_, log_, limits_, context, response);
}

grpc::ServerUnaryReactor* SceneServiceImpl::QueryUpload(grpc::CallbackServerContext* context,
                                                        const v1::QueryUploadRequest* request,
                                                        v1::QueryUploadResponse* response) {
  const CallLog::Call call = CallLog::Begin("QueryUpload", *context);
  const absl::Status status = CheckDigest("digest", request->digest());
  if (status.ok()) {
    const Store::Progress progress = store_->Query(request->digest());
    response->set_committed_bytes(progress.committed_bytes);
    response->set_complete(progress.is_complete);
  }
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(log_->End(call, status, context));
  return reactor;
}

grpc::ServerUnaryReactor* SceneServiceImpl::CreateScene(grpc::CallbackServerContext* context,
                                                        const v1::CreateSceneRequest* request,
                                                        v1::CreateSceneResponse* response) {
  return OnPool(log_, "CreateScene", scene_pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(SceneCatalog::Created created, catalog_->Create(*request));
    *response->mutable_scene() = std::move(created.scene);
    response->set_existed(created.existed);
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* SceneServiceImpl::GetScene(grpc::CallbackServerContext* context,
                                                     const v1::GetSceneRequest* request,
                                                     v1::GetSceneResponse* response) {
  return OnPool(log_, "GetScene", scene_pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(*response->mutable_scene(), catalog_->Describe(request->name()));
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* SceneServiceImpl::ListScenes(grpc::CallbackServerContext* context,
                                                       const v1::ListScenesRequest* request,
                                                       v1::ListScenesResponse* response) {
  return OnPool(log_, "ListScenes", scene_pool_, context, [this, request, response]() -> absl::Status {
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
      if (absl::IsNotFound(scene.status()) && !catalog_->Has(names[i])) continue;  // deleted meanwhile
      if (scene.ok()) {
        *response->add_scenes() = *std::move(scene);
      } else {
        // Here, but not to be loaded now.
        response->add_scenes()->set_name(names[i]);
        response->mutable_scenes()->rbegin()->add_warnings(std::string(scene.status().message()));
      }
    }
    if (names.size() > count) response->set_next_page_token(names[count - 1]);
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* SceneServiceImpl::DeleteScene(grpc::CallbackServerContext* context,
                                                        const v1::DeleteSceneRequest* request,
                                                        v1::DeleteSceneResponse*) {
  return OnPool(log_, "DeleteScene", disk_pool_, context,
                [this, request] { return catalog_->Delete(request->name()); });
}

}  // namespace halfshade
